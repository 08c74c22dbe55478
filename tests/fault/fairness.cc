// How long small calls take while a large one runs, and how far apart two equal ones end. Prints figures.
//
//   fault_fairness --curvd=PATH [--large=20000000] [--equal=2000000]
#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "tests/fault/curvd_child.h"
#include "tests/fault/raw_call.h"

namespace curvd {
namespace {

using Clock = std::chrono::steady_clock;
constexpr size_t kSmallPoints = 10'000;
constexpr int kIdleCalls = 200;

struct Flags {
  std::string curvd;
  size_t large = 20'000'000;
  size_t equal = 2'000'000;
};

// Seconds that a call for the whole cloud takes.
double RunCall(const std::shared_ptr<grpc::Channel>& channel, const FaultCloud& cloud) {
  const Clock::time_point start = Clock::now();
  curvature::v1::CloudHeader header;
  header.set_point_count(cloud.size());
  RawCall call(channel);
  call.SendHeader(header);
  call.SendCloud(cloud);
  call.HalfClose();
  const grpc::Status status = call.Finish();
  if (!status.ok()) Fail(status.error_message());
  return std::chrono::duration<double>(Clock::now() - start).count();
}

struct Spread {
  double median;
  double p90;
};

Spread SpreadOf(std::vector<double> seconds) {
  std::sort(seconds.begin(), seconds.end());
  return {seconds[seconds.size() / 2], seconds[seconds.size() * 9 / 10]};
}

void SmallBesideLarge(const CurvdChild& curvd, size_t large_points) {
  const FaultCloud small(kSmallPoints, 1), large(large_points, 2);
  const std::shared_ptr<grpc::Channel> channel = OwnChannel(curvd.address());
  RunCall(channel, small);
  std::vector<double> idle, busy;
  for (int i = 0; i < kIdleCalls; ++i) idle.push_back(RunCall(channel, small));
  std::atomic<bool> done = false;
  double large_seconds = 0.0;
  std::thread job([&] {
    large_seconds = RunCall(OwnChannel(curvd.address()), large);
    done = true;
  });
  while (!done) busy.push_back(RunCall(channel, small));
  job.join();
  const Spread alone = SpreadOf(idle), beside = SpreadOf(busy);
  std::printf(
      "%zu points, milliseconds: median %.1f, 90 %% below %.1f on the idle server; %.1f and %.1f (%zu calls) "
      "while %zu points take %.1f s; ratio of the medians %.2f (limit 3)\n",
      kSmallPoints, 1e3 * alone.median, 1e3 * alone.p90, 1e3 * beside.median, 1e3 * beside.p90, busy.size(),
      large_points, large_seconds, beside.median / alone.median);
}

void TwoEqual(const CurvdChild& curvd, size_t points) {
  const FaultCloud cloud(points, 3);
  double seconds[2];
  std::vector<std::thread> clients;
  for (double& each : seconds) {
    clients.emplace_back([&] { each = RunCall(OwnChannel(curvd.address()), cloud); });
  }
  for (std::thread& client : clients) client.join();
  const double apart = std::abs(seconds[0] - seconds[1]) / std::max(seconds[0], seconds[1]);
  std::printf("two jobs of %zu points at once: %.2f s and %.2f s, %.1f %% apart (limit 20 %%)\n", points, seconds[0],
              seconds[1], 100.0 * apart);
}

int Main(int argc, char** argv) {
  Flags flags;
  CLI::App app("How long small calls take while a large one runs", "fault_fairness");
  app.add_option("--curvd", flags.curvd)->required();
  app.add_option("--large", flags.large)->capture_default_str();
  app.add_option("--equal", flags.equal)->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  const CurvdChild curvd(flags.curvd, {"--log=false", "--threads=2"});
  SmallBesideLarge(curvd, flags.large);
  TwoEqual(curvd, flags.equal);
  return 0;
}

}  // namespace
}  // namespace curvd

int main(int argc, char** argv) { return curvd::Main(argc, argv); }
