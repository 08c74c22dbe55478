// How cost grows with the number of points, with K and shrinks with threads: the whole core on the torus, by default
// options.
#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "bench/core_run.h"
#include "bench/flags.h"
#include "bench/table.h"
#include "bench/threads.h"

namespace curvd::bench {
namespace {

EstimatorOptions Options(uint32_t k) { return OptionsFor("avg-hexagram", k, EstimatorOptions().rotation_count); }

// Seconds of a median run in one thread.
double SecondsFor(const BenchCloud& cloud, uint32_t k, int rounds, WorkerPool& pool) {
  SideBySide comparison(absl::StrCat(cloud.name, " ", cloud.size(), " K=", k));
  comparison.Add("curvd", [&] { return RunCore(cloud, Options(k), pool); });
  return comparison.Run(rounds)["curvd"]["total"];
}

void GrowPoints(const Flags& flags, WorkerPool& pool, Targets& targets) {
  Table table("scaling_points", {"points", "K", "us/point", "us/point/log2(points)"});
  std::vector<size_t> sizes = {10'000, 30'000, 100'000, 300'000};
  if (!flags.quick) sizes.insert(sizes.end(), {1'000'000, 3'000'000});
  if (flags.full) sizes.push_back(10'000'000);
  double first = 0.0, worst = 0.0;
  for (size_t size : sizes) {
    const BenchCloud cloud = SurfaceCloud("torus", size, flags.clouds);
    // Small clouds take milliseconds: more rounds cost nothing.
    const int rounds = flags.RoundsOr(size < 1'000'000 ? 15 : 3);
    const auto points = static_cast<double>(size);
    const double micros = 1e6 * SecondsFor(cloud, 50, rounds, pool) / points;
    const double per_log = micros / std::log2(points);
    table.AddRow({absl::StrCat(size), "50", Digits(micros), Digits(per_log)});
    if (first > 0.0) worst = std::max(worst, per_log / first);
    if (first == 0.0) first = per_log;
  }
  table.Finish(flags.out);
  targets.AtMost(absl::StrCat("cost over N log N; N from 10000 to ", sizes.back(), " against the smallest"), 1.0, worst,
                 "x");
}

void GrowNeighborhoods(const Flags& flags, WorkerPool& pool, Targets& targets) {
  Table table("scaling_neighbors", {"points", "K", "us/point", "us/point/K"});
  const BenchCloud cloud = SurfaceCloud("torus", flags.quick ? 50'000 : 500'000, flags.clouds);
  double first = 0.0, worst = 0.0;
  for (uint32_t k : {15u, 25u, 50u, 100u, 200u, 300u, 500u, 1000u}) {
    const double micros = 1e6 * SecondsFor(cloud, k, flags.RoundsOr(5), pool) / static_cast<double>(cloud.size());
    const double per_neighbor = micros / k;
    table.AddRow({absl::StrCat(cloud.size()), absl::StrCat(k), Digits(micros), Digits(per_neighbor)});
    if (first > 0.0) worst = std::max(worst, per_neighbor / first);
    if (first == 0.0) first = per_neighbor;
  }
  table.Finish(flags.out);
  targets.AtMost("cost over K; K from 15 to 1000 against the smallest", 1.0, worst, "x");
}

void AddThreads(const Flags& flags, Targets& targets) {
  Table table("scaling_threads", {"cloud", "points", "K", "1 thread s", "2 threads s", "speedup", "control speedup"});
  WorkerPool one(1), two(2);
  for (const char* surface : {"torus", "goursat"}) {
    const BenchCloud cloud = SurfaceCloud(surface, flags.quick ? 50'000 : 500'000, flags.clouds);
    for (uint32_t k : {50u, 300u}) {
      SideBySide comparison(absl::StrCat(surface, " ", cloud.size(), " K=", k));
      comparison.Add("1 thread", [&] { return RunCore(cloud, Options(k), one); });
      comparison.Add("2 threads", [&] { return RunCore(cloud, Options(k), two); });
      comparison.Add("control; 1 thread", [] { return Spin(1); });
      comparison.Add("control; 2 threads", [] { return Spin(2); });
      auto medians = comparison.Run(flags.RoundsOr(7));
      const double single = medians["1 thread"]["wall"], both = medians["2 threads"]["wall"];
      const double control = medians["control; 1 thread"]["wall"] / medians["control; 2 threads"]["wall"];
      table.AddRow({surface, absl::StrCat(cloud.size()), absl::StrCat(k), Digits(single), Digits(both),
                    Digits(single / both), Digits(control)});
      AddSpeedup(absl::StrCat(surface, " K=", k, ": two threads over one; index to field; wall clock"), single / both,
                 control, targets);
    }
  }
  table.Finish(flags.out);
}

void Main(const Flags& flags) {
  Targets targets("scaling");
  {
    WorkerPool pool(1);
    GrowPoints(flags, pool, targets);
    GrowNeighborhoods(flags, pool, targets);
  }
  AddThreads(flags, targets);
  targets.Finish(flags.out);
}

}  // namespace
}  // namespace curvd::bench

int main(int argc, char** argv) {
  curvd::bench::Main(curvd::bench::ParseFlags(argc, argv, "Cost against points, neighbors and threads"));
}
