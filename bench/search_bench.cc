// Neighbor search alone, index build included: nanoflann in two ways, and the core's two searches.
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "absl/strings/str_cat.h"
#include "bench/core_search.h"
#include "bench/flags.h"
#include "bench/peers/peers.h"
#include "bench/stopwatch.h"
#include "bench/table.h"

namespace curvd::bench {
namespace {

constexpr char kGroups[] = "curvd by groups";
constexpr char kDescent[] = "curvd by descent";
constexpr char kCommon[] = "nanoflann double leaf 10 input order";
constexpr char kStrongest[] = "nanoflann float leaf 32 heap Morton order";
constexpr const char* kWays[] = {kGroups, kDescent, kCommon, kStrongest};

using Radii = std::map<std::string, std::vector<float>>;

template <typename Search>
void AddOurs(const BenchCloud& cloud, const char* way, uint32_t k, Search search, Radii& radii,
             SideBySide& comparison) {
  comparison.Add(way, [=, &cloud, &radii] {
    Cloud input = ToCloud(cloud);
    std::vector<float>& out = radii[way];
    out.assign(cloud.size(), 0.0f);
    const double start = CpuSeconds();
    const SpatialIndex index = BuildIndex(std::move(input));
    const double built = CpuSeconds();
    search(index, k, out.data());
    const double end = CpuSeconds();
    return Figures{{"total", end - start}, {"build", built - start}, {"query", end - built}};
  });
}

template <typename Run>
void AddPeer(const BenchCloud& cloud, const char* way, Run run, Radii& radii, SideBySide& comparison) {
  comparison.Add(way, [=, &cloud, &radii] {
    std::vector<PointCurvature> field(cloud.size());
    const PeerCost cost = run(field.data());
    std::vector<float>& out = radii[way];
    out.clear();
    for (const PointCurvature& point : field) out.push_back(point.radius);
    return Figures{{"total", cost.build + cost.query}, {"build", cost.build}, {"query", cost.query}};
  });
}

// Every search must have found the same radii; ends the program otherwise.
void CheckRadii(Radii& radii) {
  constexpr float kTolerance = 1e-6f;  // the rounding of float distances
  const std::vector<float>& exact = radii.at(kCommon);
  for (const char* way : kWays) {
    for (size_t i = 0; i < exact.size(); ++i) {
      if (std::abs(radii[way][i] - exact[i]) <= kTolerance * exact[i]) continue;
      std::fprintf(stderr, "%s: radius %g of point %zu should be %g: the comparison is void\n", way, radii[way][i], i,
                   exact[i]);
      std::exit(1);
    }
  }
}

void Measure(const BenchCloud& cloud, uint32_t k, int rounds, Table& table) {
  const std::vector<double> positions(cloud.positions.begin(), cloud.positions.end());
  Radii radii;
  SideBySide comparison(absl::StrCat(cloud.name, " ", cloud.size(), " K=", k));
  const auto by_groups = [](const SpatialIndex& index, uint32_t count, float* out) {
    SearchByGroups(index, "avg-hexagram", count, out);
  };
  AddOurs(cloud, kGroups, k, by_groups, radii, comparison);
  AddOurs(cloud, kDescent, k, SearchByDescent, radii, comparison);
  AddPeer(
      cloud, kCommon,
      [&positions, k](PointCurvature* out) { return RunCommonWay(positions, {}, k, PeerWork::kSearch, out); }, radii,
      comparison);
  AddPeer(
      cloud, kStrongest,
      [&cloud, k](PointCurvature* out) { return RunStrongestPeer(cloud.positions, {}, k, PeerWork::kSearch, out); },
      radii, comparison);
  auto medians = comparison.Run(rounds);
  CheckRadii(radii);
  for (const char* way : kWays) {
    const auto micros = [&](const char* figure) {
      return Digits(1e6 * medians[way][figure] / static_cast<double>(cloud.size()));
    };
    table.AddRow({cloud.name, absl::StrCat(cloud.size()), absl::StrCat(k), way, micros("build"), micros("query"),
                  micros("total"), Digits(medians[way]["total"] / medians[kGroups]["total"])});
  }
}

void Main(const Flags& flags) {
  Table table("search", {"cloud", "points", "K", "way", "build us/point", "search us/point", "total us/point",
                         "times curvd by groups"});
  for (const char* surface : {"torus", "goursat"}) {
    const BenchCloud cloud = SurfaceCloud(surface, flags.quick ? 50'000 : 500'000, flags.clouds);
    for (uint32_t k : {50u, 300u}) Measure(cloud, k, flags.RoundsOr(5), table);
  }
  table.Finish(flags.out);
}

}  // namespace
}  // namespace curvd::bench

int main(int argc, char** argv) {
  curvd::bench::Main(curvd::bench::ParseFlags(argc, argv, "Neighbor search alone, against nanoflann"));
}
