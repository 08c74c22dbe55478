#include "client/cli/progress_bar.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/time/clock.h"
#include "client/cli/command.h"
#include "client/cli/numbers.h"

namespace curv {
namespace {

using Phase = EstimateProgress::Phase;

const char* Word(Phase phase) {
  static constexpr const char* kWords[] = {"connecting", "sending",   "waiting",    "indexing",
                                           "normals",    "orienting", "estimating", "receiving"};
  return kWords[static_cast<size_t>(phase)];
}

// Points that the phase has done.
uint64_t PointsDone(const EstimateProgress& progress) {
  switch (progress.phase) {
    case Phase::kSending:
      return progress.points_sent;
    case Phase::kEstimating:
      return progress.points_estimated;
    case Phase::kReceiving:
      return progress.points_received;
    default:
      return 0;
  }
}

double Percent(uint64_t part, uint64_t whole) {
  return whole == 0 ? 100.0 : 100.0 * static_cast<double>(part) / static_cast<double>(whole);
}

std::string Bar(double percent) {
  constexpr int kCells = 20;
  const int full = std::clamp(static_cast<int>(percent / 100.0 * kCells), 0, kCells);
  return absl::StrCat("[", std::string(static_cast<size_t>(full), '#'),
                      std::string(static_cast<size_t>(kCells - full), '.'), "]");
}

// Whether stderr is a terminal that moves its cursor when asked to.
bool CanRedrawLine() {
  const char* terminal = std::getenv("TERM");
  return isatty(STDERR_FILENO) != 0 && terminal != nullptr && std::string_view(terminal) != "dumb";
}

}  // namespace

std::string ProgressLine(const EstimateProgress& progress, double seconds) {
  const bool estimated = progress.phase == Phase::kReceiving;
  const uint64_t done = PointsDone(progress);
  std::string line =
      absl::StrFormat("%-10s %s received %3.0f %%, estimated %3.0f %%", Word(progress.phase),
                      Bar(Percent(done, progress.points)), Percent(progress.points_sent, progress.points),
                      Percent(estimated ? progress.points : progress.points_estimated, progress.points));
  if (done > 0 && seconds > 0.0) {
    const double rate = static_cast<double>(done) / seconds;
    const double left = static_cast<double>(progress.points - std::min(done, progress.points)) / rate;
    absl::StrAppend(&line, ", ", WithPrefix(rate), " points/s, ETA ", Clock(left));
  }
  if (progress.attempt > 1) absl::StrAppend(&line, " (attempt ", progress.attempt, ")");
  return line;
}

std::string BatchLine(const BatchShare& share, const EstimateProgress& progress) {
  // A file is done to the half when all of it was sent, and for the rest when all of it was estimated.
  const double estimated =
      progress.phase == Phase::kReceiving ? 100.0 : Percent(progress.points_estimated, progress.points);
  const double done = progress.phase == Phase::kConnecting
                          ? 0.0
                          : std::clamp(0.5 * (Percent(progress.points_sent, progress.points) + estimated), 0.0, 100.0);
  const double all = 100.0 * share.begin + (share.end - share.begin) * done;
  return absl::StrFormat("%s %3.0f %%, %s%s %3.0f %%", Bar(all), all, share.title, Word(progress.phase), done);
}

ProgressBar::ProgressBar(std::optional<BatchShare> share)
    : share_(std::move(share)), visible_(CanRedrawLine()), phase_start_(absl::Now()) {}

ProgressBar::~ProgressBar() {
  if (drawn_) std::fputs("\r\x1b[K", stderr);
}

void ProgressBar::Show(const EstimateProgress& progress) {
  if (!visible_) return;
  const absl::Time now = absl::Now();
  if (progress.phase != phase_) {
    phase_ = progress.phase;
    phase_start_ = now;
  }
  if (now - last_ < absl::Milliseconds(100)) return;
  last_ = now;
  drawn_ = true;
  const std::string line = share_.has_value() ? BatchLine(*share_, progress)
                                              : ProgressLine(progress, absl::ToDoubleSeconds(now - phase_start_));
  std::fprintf(stderr, "\r\x1b[K%s", Visible(line).c_str());
}

}  // namespace curv
