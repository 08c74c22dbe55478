// Mixed load for a long time, beside a caller who wants to harm the others, and strangers who attack by HTTP/2. Every
// result is compared with a direct computation; memory, descriptors and threads are looked at whenever the server is
// idle, which it is made to be now and then.
//
//   fault_soak --curvd=PATH [--attacks=http2_attacks.py] [--duration=30m] [--max-points=5000000] [--clients=48]
//              [--hostile-clients=4]
// Ends with status 1 on a finding.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "tests/fault/curvd_child.h"
#include "tests/fault/soak_load.h"
#include "tests/fault/soak_strangers.h"
#include "tests/fault/token_file.h"

namespace curvd {
namespace {

using Clock = std::chrono::steady_clock;
// Times that the load pauses; a third of them is compared with the next.
constexpr int kMinPauses = 6, kMaxPauses = 60;
constexpr absl::Duration kBetweenPauses = absl::Seconds(30);
// How long the connections of the clients take to close.
constexpr auto kClosing = std::chrono::milliseconds(500);
// Below this, the allocator has not yet seen each kind of load often enough to be compared with itself.
constexpr absl::Duration kJudgedFrom = absl::Minutes(5);

struct Flags {
  std::string curvd;
  std::string attacks;
  absl::Duration duration = absl::Minutes(30);
  size_t max_points = 5'000'000;
  int clients = 48;
  int hostile_clients = 4;
  int stall_seconds = 5;
};

void RunLoad(const CurvdChild& curvd, const std::vector<SoakCase>& cases, const Flags& flags, Clock::time_point end,
             uint64_t seed, SoakCounts& counts) {
  const SoakStrangers strangers(flags.attacks, curvd.address());
  std::vector<std::jthread> threads;
  for (int client = 0; client < flags.clients + flags.hostile_clients; ++client) {
    threads.emplace_back([&, client] {
      std::mt19937_64 random(seed * 1'000 + client);
      while (Clock::now() < end && counts.finding().empty()) {
        if (client < flags.clients) {
          MakeSoakCall(curvd.address(), flags.stall_seconds, cases, random, counts);
        } else {
          MakeHostileCall(curvd.address(), random, counts);
        }
      }
    });
  }
}

// What the server tells of strangers whose connections it ended itself.
double EndedStrangers(const CurvdChild& curvd) {
  double ended = 0.0;
  for (const char* reason : {"unaccounted_bytes", "too_much_metadata", "memory_short"}) {
    ended += curvd.Metric(absl::StrCat("curvd_strangers_total{reason=\"", reason, "\"}"));
  }
  return ended;
}

// The middle of `number` of the samples from `first` on, `count` of them.
double Median(const std::vector<ProcessUsage>& samples, size_t first, size_t count,
              double (*number)(const ProcessUsage&)) {
  std::vector<double> numbers;
  for (size_t i = first; i < first + count; ++i) numbers.push_back(number(samples[i]));
  std::nth_element(numbers.begin(), numbers.begin() + numbers.size() / 2, numbers.end());
  return numbers[numbers.size() / 2];
}

struct Measure {
  const char* name;
  double (*number)(const ProcessUsage&);
  double allowed_growth;  // of the last third over the middle third
};
constexpr Measure kMeasures[] = {
    {"resident MiB", [](const ProcessUsage& u) { return static_cast<double>(u.resident_bytes) / (1 << 20); }, 0.02},
    {"threads", [](const ProcessUsage& u) { return static_cast<double>(u.threads); }, 0.0},
    {"descriptors", [](const ProcessUsage& u) { return static_cast<double>(u.descriptors); }, 0.0},
};

// Prints the thirds; returns what grew, or "".
std::string Compare(const std::vector<ProcessUsage>& samples) {
  const size_t third = samples.size() / 3;
  std::string grown;
  std::printf("| idle server, medians | first third | middle third | last third |\n| --- | --: | --: | --: |\n");
  for (const Measure& measure : kMeasures) {
    const double first = Median(samples, 0, third, measure.number);
    const double middle = Median(samples, third, third, measure.number);
    const double last = Median(samples, 2 * third, third, measure.number);
    std::printf("| %s | %.1f | %.1f | %.1f |\n", measure.name, first, middle, last);
    if (last > middle * (1.0 + measure.allowed_growth)) {
      grown = absl::StrCat(measure.name, " grew from ", middle, " to ", last);
    }
  }
  return grown;
}

int Main(int argc, char** argv) {
  Flags flags;
  std::string duration = "30m";
  CLI::App app("Mixed load for a long time", "fault_soak");
  app.add_option("--curvd", flags.curvd)->required();
  app.add_option("--duration", duration, "such as 30m")->capture_default_str();
  app.add_option("--max-points", flags.max_points, "of the largest cloud")->capture_default_str();
  app.add_option("--stall-seconds", flags.stall_seconds, "after which the server ends a stalled call")
      ->capture_default_str();
  app.add_option("--clients", flags.clients, "calls at a time")->capture_default_str();
  app.add_option("--hostile-clients", flags.hostile_clients, "calls of mallory's at a time")->capture_default_str();
  app.add_option("--attacks", flags.attacks, "http2_attacks.py, if strangers shall attack");
  CLI11_PARSE(app, argc, argv);
  if (!absl::ParseDuration(duration, &flags.duration)) Fail(absl::StrCat("--duration is ", duration, ", not like 30m"));

  const std::vector<SoakCase> cases = MakeSoakCases(flags.max_points);
  const TokenFile tokens;
  const CurvdChild curvd(
      flags.curvd,
      {"--log=false", "--threads=2", "--memory-limit=2GiB", "--max-connections-per-peer=1000",
       absl::StrCat("--stall-timeout=", flags.stall_seconds, "s"), absl::StrCat("--token-file=", tokens.path())});
  SoakCounts counts;
  std::vector<ProcessUsage> samples;
  const int pauses = std::clamp(static_cast<int>(flags.duration / kBetweenPauses), kMinPauses, kMaxPauses);
  const auto step = absl::ToChronoNanoseconds(flags.duration / pauses);
  const Clock::time_point start = Clock::now();
  for (int pause = 1; pause <= pauses && counts.finding().empty(); ++pause) {
    // What a pause took is not added to the end.
    RunLoad(curvd, cases, flags, std::max(start + pause * step, Clock::now() + step / 10), pause, counts);
    curvd.WaitUntilIdle();
    std::this_thread::sleep_for(kClosing);
    samples.push_back(curvd.Usage());
  }
  std::printf(
      "%.0f s; calls: %zu right (%zu points), %zu cancelled, %zu past their deadline, %zu with bad input, %zu "
      "stalled, %zu asked to wait; %zu hostile; %.0f connections of strangers ended; peak %.0f MiB\n",
      std::chrono::duration<double>(Clock::now() - start).count(), counts.right.load(), counts.points.load(),
      counts.cancelled.load(), counts.timed_out.load(), counts.refused_input.load(), counts.stalled.load(),
      counts.asked_to_wait.load(), counts.hostile.load(), EndedStrangers(curvd),
      static_cast<double>(curvd.Usage().peak_bytes) / (1 << 20));
  std::string finding = counts.finding();
  if (curvd.Metric("curvd_failures_total{reason=\"INTERNAL\"}") != 0.0) finding = "a call ended with INTERNAL";
  if (finding.empty() && !flags.attacks.empty() && EndedStrangers(curvd) == 0.0) finding = "no stranger was ended";
  const std::string grown = finding.empty() ? Compare(samples) : "";
  const bool is_judged = flags.duration >= kJudgedFrom;
  if (finding.empty() && is_judged) finding = grown;
  if (!finding.empty()) Fail(finding);
  std::printf("verdict: nothing wrong, %s\n", is_judged ? "nothing grew" : "too short to say what grows");
  return 0;
}

}  // namespace
}  // namespace curvd

int main(int argc, char** argv) { return curvd::Main(argc, argv); }
