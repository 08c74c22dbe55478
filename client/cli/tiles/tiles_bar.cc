#include "client/cli/tiles/tiles_bar.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/time/clock.h"
#include "client/cli/numbers.h"

namespace curv {

TilesBar::TilesBar() : visible_(isatty(STDERR_FILENO) != 0), step_start_(absl::Now()) {}

TilesBar::~TilesBar() {
  if (drawn_) std::fputs("\r\x1b[K", stderr);
}

void TilesBar::Show(const std::string& step, uint64_t done, uint64_t of, const std::string& what) {
  if (!visible_) return;
  const absl::Time now = absl::Now();
  if (step != step_) {
    step_ = step;
    step_start_ = now;
    step_first_ = done;
  }
  if (now - last_ < absl::Milliseconds(100)) return;
  last_ = now;
  drawn_ = true;
  std::string line = absl::StrFormat("%-10s ", step);
  if (of > 0) {
    constexpr uint64_t kCells = 20;
    const uint64_t full = std::min(kCells, done * kCells / of);
    absl::StrAppend(&line, "[", std::string(full, '#'), std::string(kCells - full, '.'), "] ",
                    absl::StrFormat("%3d %%", std::min<uint64_t>(100, done * 100 / of)), " of ");
  }
  absl::StrAppend(&line, WithPrefix(static_cast<double>(of > 0 ? of : done)), " points", what);
  const double seconds = absl::ToDoubleSeconds(now - step_start_);
  if (done > step_first_ && seconds > 0.0) {
    const double rate = static_cast<double>(done - step_first_) / seconds;
    absl::StrAppend(&line, ", ", WithPrefix(rate), " points/s");
    if (of > done) absl::StrAppend(&line, ", ETA ", Clock(static_cast<double>(of - done) / rate));
  }
  std::fprintf(stderr, "\r\x1b[K%s", line.c_str());
}

}  // namespace curv
