#include "bench/paper/grid.h"

#include <filesystem>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace curvd::bench {
namespace {

constexpr const char* kSurfaces[] = {"goursat", "torus"};
constexpr double kNoiseLevels[] = {0.0, 0.1, 0.2};

// Clouds of one size, and how often their noise is drawn anew.
struct EvenClouds {
  size_t points;
  uint64_t realizations;
  bool all_neighbor_counts;  // or every second, from the second on
};

struct Extent {
  std::vector<EvenClouds> even;
  std::vector<uint32_t> neighbor_counts;
  std::vector<uint32_t> peer_neighbor_counts;  // for the paper's clouds: those at which the peers were measured
  uint64_t peer_realizations;
  std::vector<size_t> thinned_points;
};

Extent ExtentOf(GridSize size) {
  switch (size) {
    case GridSize::kTiny:
      return {{{500, 2, true}}, {15, 50}, {50}, 1, {500}};
    case GridSize::kQuick:
      return {{{10'000, 2, true}, {25'000, 1, true}}, {15, 50, 100, 200, 400}, {15, 50, 200}, 1, {25'000}};
    case GridSize::kWhole:
      break;
  }
  // Half of the work is in the large clouds; figures over K use those of 25,000 points.
  return {{{10'000, 3, true}, {25'000, 3, true}, {50'000, 1, false}, {75'000, 1, false}, {100'000, 1, false}},
          {10, 15, 25, 50, 75, 100, 150, 200, 300, 400},
          {15, 50, 200, 400},
          2,
          {25'000}};
}

// One GridCloud for each noise level and realization of `cloud`, whose samples `make(realization)` gives.
template <typename Make>
void AddNoisy(const GridCloud& cloud, uint64_t realizations, Make make, std::vector<GridCloud>& grid) {
  for (double position : kNoiseLevels) {
    for (double normal : kNoiseLevels) {
      for (uint64_t realization = 1; realization <= realizations; ++realization) {
        GridCloud added = cloud;
        added.noise = {position, normal};
        added.realization = realization;
        added.undisturbed = [make, realization] { return make(realization); };
        grid.push_back(std::move(added));
      }
    }
  }
}

void AddEven(const std::string& surface, const Extent& extent, std::vector<GridCloud>& grid) {
  for (const EvenClouds& even : extent.even) {
    GridCloud cloud{surface, "even", even.points, {}, 0, {}, {}};
    const size_t step = even.all_neighbor_counts ? 1 : 2;
    for (size_t i = step - 1; i < extent.neighbor_counts.size(); i += step) {
      cloud.neighbor_counts.push_back(extent.neighbor_counts[i]);
    }
    AddNoisy(
        cloud, even.realizations,
        [surface, points = even.points](uint64_t seed) { return SampleEvenly(surface, points, seed); }, grid);
  }
}

// The clouds that the peers were measured on.
void AddPeers(const std::string& surface, const Extent& extent, const std::string& folder,
              std::vector<GridCloud>& grid) {
  for (size_t points : {25'000, 50'000}) {
    const std::string path = absl::StrFormat("%s/%s_%06d.pts", folder, surface, points);
    if (!std::filesystem::exists(path)) continue;
    const GridCloud cloud{surface, "paper", points, {}, 0, {}, extent.peer_neighbor_counts};
    AddNoisy(
        cloud, extent.peer_realizations, [surface, path](uint64_t) { return *LoadSamples(path, surface, "paper"); },
        grid);
  }
}

void AddNonUniform(const std::string& surface, const Extent& extent, const std::string& folder,
                   std::vector<GridCloud>& grid) {
  const auto add = [&](const std::string& sampling, size_t points, std::function<Samples()> make) {
    grid.push_back({surface, sampling, points, {}, 1, std::move(make), extent.neighbor_counts});
  };
  for (size_t points : extent.thinned_points) {
    add("thinned", points, [surface, points] { return SampleThinned(surface, points, 1); });
  }
  add("scanned", 0, [surface] { return SampleScanned(surface); });
  for (const char* sampling : {"filter", "lidar"}) {
    const std::string path = absl::StrCat(folder, "/", surface, "-", sampling, ".pts");
    if (!std::filesystem::exists(path)) continue;
    add(sampling, 0, [surface, path, sampling] { return *LoadSamples(path, surface, sampling); });
  }
}

}  // namespace

std::vector<GridCloud> PaperGrid(GridSize size, const std::string& paper_folder) {
  const Extent extent = ExtentOf(size);
  std::vector<GridCloud> grid;
  for (const std::string surface : kSurfaces) {
    AddEven(surface, extent, grid);
    if (size != GridSize::kTiny) AddPeers(surface, extent, paper_folder, grid);
    AddNonUniform(surface, extent, paper_folder, grid);
  }
  return grid;
}

}  // namespace curvd::bench
