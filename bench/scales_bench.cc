// Several scales with one search, beside the largest alone and beside a call for each; whole core in one thread.
#include <algorithm>
#include <vector>

#include "absl/strings/str_cat.h"
#include "bench/core_run.h"
#include "bench/flags.h"
#include "bench/table.h"

namespace curvd::bench {
namespace {

// In descending order.
constexpr uint32_t kCounts[] = {2048, 1024, 512, 256, 128, 64, 32, 16};

EstimatorOptions ScalesOptions(std::string_view estimator) {
  EstimatorOptions options = OptionsFor(estimator, kCounts[0], 2);
  options.smaller_counts.size = std::size(kCounts) - 1;
  std::copy(std::begin(kCounts) + 1, std::end(kCounts), options.smaller_counts.counts.begin());
  return options;
}

void Measure(const BenchCloud& cloud, std::string_view estimator, int rounds, WorkerPool& pool, Table& table,
             Targets& targets) {
  const EstimatorOptions scales = ScalesOptions(estimator);
  SideBySide comparison(absl::StrCat(cloud.name, " ", cloud.size(), " ", std::string(estimator)));
  comparison.Add("scales", [&] { return RunCore(cloud, scales, pool); });
  comparison.Add("largest", [&] { return RunCore(cloud, scales.AtScale(0), pool); });
  comparison.Add("each", [&] {
    Figures sum;
    for (size_t scale = 0; scale < scales.scale_count(); ++scale) {
      for (const auto& [name, value] : RunCore(cloud, scales.AtScale(scale), pool)) sum[name] += value;
    }
    return sum;
  });
  auto medians = comparison.Run(rounds);
  const double largest = medians["largest"]["total"];
  for (const char* way : {"largest", "scales", "each"}) {
    table.AddRow({cloud.name, absl::StrCat(cloud.size()), std::string(estimator), way,
                  Digits(1e6 * medians[way]["total"] / static_cast<double>(cloud.size())),
                  Digits(medians[way]["total"] / largest)});
  }
  targets.AtMost(absl::StrCat(cloud.name, ", ", std::string(estimator), ": eight scales over the largest"), 1.3,
                 medians["scales"]["total"] / largest, "x");
}

void Main(const Flags& flags) {
  Table table("scales", {"cloud", "points", "estimator", "way", "total us/point", "times the largest"});
  Targets targets("scales");
  WorkerPool pool(1);
  for (const char* surface : {"torus", "goursat"}) {
    const BenchCloud cloud = SurfaceCloud(surface, flags.quick ? 20'000 : 100'000, flags.clouds);
    for (const std::string_view estimator : {"avg-hexagram", "normal-regression"}) {
      Measure(cloud, estimator, flags.RoundsOr(5), pool, table, targets);
    }
  }
  table.Finish(flags.out);
  targets.Finish(flags.out);
}

}  // namespace
}  // namespace curvd::bench

int main(int argc, char** argv) {
  curvd::bench::Main(curvd::bench::ParseFlags(argc, argv, "Eight scales with one search, in one thread"));
}
