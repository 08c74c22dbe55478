// Each estimator over K, whole core in one thread.
#include <algorithm>

#include "absl/strings/str_cat.h"
#include "bench/core_run.h"
#include "bench/flags.h"
#include "bench/table.h"

namespace curvd::bench {
namespace {

struct NamedEstimator {
  const char* name;
  std::string_view kind;
  uint32_t rotations;
};
constexpr NamedEstimator kEstimators[] = {{"avg-hexagram, 1 rotation", "avg-hexagram", 1},
                                          {"avg-hexagram, 2 rotations (default)", "avg-hexagram", 2},
                                          {"hexagram", "hexagram", 1},
                                          {"uniform, 100 triangles", "uniform", 1},
                                          {"independent, 100 triangles", "independent", 1},
                                          {"delaunay", "delaunay", 1},
                                          {"jet, degree 2", "jet", 1},
                                          {"algebraic shape operator", "aso", 1},
                                          {"normal regression", "normal-regression", 1}};

double MicrosPerPoint(const BenchCloud& cloud, Figures& figures) {
  return 1e6 * figures["total"] / static_cast<double>(cloud.size());
}

// Adds the rows of one K; the hexagram's cost over avg-hexagram's with the same K goes to `ratios`, by rotations.
void CompareEstimators(const BenchCloud& cloud, uint32_t k, int rounds, WorkerPool& pool, Table& table,
                       std::map<uint32_t, double>& ratios) {
  SideBySide comparison(absl::StrCat(cloud.name, " ", cloud.size(), " K=", k));
  for (const NamedEstimator& estimator : kEstimators) {
    comparison.Add(estimator.name,
                   [&, k] { return RunCore(cloud, OptionsFor(estimator.kind, k, estimator.rotations), pool); });
  }
  auto medians = comparison.Run(rounds);
  const double paper = MicrosPerPoint(cloud, medians[kEstimators[0].name]);
  for (const NamedEstimator& estimator : kEstimators) {
    const double micros = MicrosPerPoint(cloud, medians[estimator.name]);
    table.AddRow({cloud.name, absl::StrCat(cloud.size()), absl::StrCat(k), estimator.name, Digits(micros),
                  Digits(micros / paper)});
  }
  const double hexagram = MicrosPerPoint(cloud, medians["hexagram"]);
  for (const NamedEstimator& estimator : {kEstimators[0], kEstimators[1]}) {
    ratios[estimator.rotations] = hexagram / MicrosPerPoint(cloud, medians[estimator.name]);
  }
}

// The hexagram's cost at several K in turns; returns the largest over the smallest.
double CompareHexagrams(const BenchCloud& cloud, int rounds, WorkerPool& pool, Table& table) {
  constexpr uint32_t kCounts[] = {50, 100, 200, 500, 1000};
  SideBySide comparison(absl::StrCat(cloud.name, " ", cloud.size(), " hexagram"));
  for (uint32_t k : kCounts) {
    comparison.Add(absl::StrCat("K=", k), [&, k] { return RunCore(cloud, OptionsFor("hexagram", k), pool); });
  }
  auto medians = comparison.Run(rounds);
  double least = 1e9, most = 0.0;
  for (uint32_t k : kCounts) {
    const double micros = MicrosPerPoint(cloud, medians[absl::StrCat("K=", k)]);
    table.AddRow({cloud.name, absl::StrCat(cloud.size()), absl::StrCat(k), Digits(micros)});
    least = std::min(least, micros);
    most = std::max(most, micros);
  }
  return most / least;
}

void Main(const Flags& flags) {
  Table table("estimators", {"cloud", "points", "K", "estimator", "total us/point", "times avg-hexagram (1 rotation)"});
  Table hexagrams("hexagram", {"cloud", "points", "K", "total us/point"});
  Targets targets("estimators");
  WorkerPool pool(1);
  for (const char* surface : {"torus", "goursat"}) {
    const BenchCloud cloud = SurfaceCloud(surface, flags.quick ? 50'000 : 500'000, flags.clouds);
    for (uint32_t k : {15u, 50u, 100u, 300u}) {
      std::map<uint32_t, double> ratios;
      const bool has_targets = k == 50;
      CompareEstimators(cloud, k, flags.RoundsOr(has_targets ? 15 : 5), pool, table, ratios);
      if (!has_targets) continue;
      const std::string what = absl::StrCat(surface, " K=50: hexagram over avg-hexagram");
      targets.AtMost(absl::StrCat(what, " (1 rotation)"), 1.0, ratios[1], "x");
      targets.AtMost(absl::StrCat(what, " (default)"), 1.0, ratios[2], "x");
    }
    targets.AtMost(absl::StrCat(surface, ": hexagram's dearest K over its cheapest; 50 to 1000"), 1.1,
                   CompareHexagrams(cloud, flags.RoundsOr(31), pool, hexagrams), "x");
  }
  table.Finish(flags.out);
  hexagrams.Finish(flags.out);
  targets.Finish(flags.out);
}

}  // namespace
}  // namespace curvd::bench

int main(int argc, char** argv) {
  curvd::bench::Main(curvd::bench::ParseFlags(argc, argv, "Each estimator over K, in one thread"));
}
