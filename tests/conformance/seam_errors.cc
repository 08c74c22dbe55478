// Shows what estimates do with normals that point to both sides of a surface, and that right normals are left alone.
// Prints two tables.
//
//   seam_errors POINTS [SHARED_DIR [EVERY]]
//
// Wrong normals: spheres of POINTS points of which single normals or whole halves are flipped, and the scan
// armadillo100k as it is on disk. No point may be OK whose neighborhood crosses a seam. Right normals: goursat, torus,
// the scan once it is oriented, plates, gaps, shells and lenses. Every byte of their results must be that of an
// estimate by the same strategy which looks for no seam; those that are made have POINTS / 2 points. Exit code 1 if one
// is otherwise. Clouds that are not in SHARED_DIR/data are left out, and named; without SHARED_DIR all of them are.
// Of those that are there each EVERYth estimate is tried, by default all.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "client/io/oriented_cloud.h"
#include "client/io/table_file.h"
#include "client/surfaces/noise.h"
#include "client/surfaces/surface.h"
#include "core/estimators/strategies.h"
#include "core/job/estimation_job.h"
#include "core/job/normals_job.h"
#include "tests/core/seam_clouds.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

[[noreturn]] void Fail(const absl::Status& status) {
  std::fprintf(stderr, "%s\n", status.ToString().c_str());
  std::exit(2);
}

struct NamedPoints {
  std::string name;
  TestPoints points;
  size_t every = 1;  // which of the estimates are tried
};

// Nothing if the file does not exist.
std::optional<TestPoints> LoadPoints(const std::string& path) {
  if (!std::filesystem::exists(path)) {
    std::printf("left out: %s\n", std::filesystem::path(path).filename().c_str());
    return std::nullopt;
  }
  const auto table = curv::LoadTable(path);
  if (!table.ok()) Fail(table.status());
  const auto cloud = curv::ExtractCloud(*table);
  if (!cloud.ok()) Fail(cloud.status());
  TestPoints points;
  std::visit(
      [&](const auto& packed) {
        const auto& p = packed.positions;
        const auto& n = packed.normals;
        for (size_t i = 0; i + 2 < p.size(); i += 3) points.Add(p[i], p[i + 1], p[i + 2], n[i], n[i + 1], n[i + 2]);
      },
      *cloud);
  return points;
}

// The points in cubes, so that those near a place are found.
class Cubes {
 public:
  Cubes(const TestPoints& points, double edge) : points_(points), edge_(edge) {
    for (uint32_t i = 0; i < points.size(); ++i) members_.push_back({KeyOf(points.positions[i]), i});
    std::sort(members_.begin(), members_.end());
  }

  // Calls visit(j, distance) for the points within `reach` of point i, itself included.
  template <typename Visit>
  void ForEachWithin(size_t i, double reach, Visit visit) const {
    const auto& at = points_.positions[i];
    Key low{}, high{};
    for (size_t axis = 0; axis < 3; ++axis) {
      low[axis] = static_cast<int>(std::floor((at[axis] - reach) / edge_));
      high[axis] = static_cast<int>(std::floor((at[axis] + reach) / edge_));
    }
    for (int x = low[0]; x <= high[0]; ++x) {
      for (int y = low[1]; y <= high[1]; ++y) {
        // The cubes of a column come one after the other.
        auto member = std::lower_bound(members_.begin(), members_.end(), Member{{x, y, low[2]}, 0});
        for (; member != members_.end() && member->first <= Key{x, y, high[2]}; ++member) {
          const auto& p = points_.positions[member->second];
          const double distance = std::hypot(double{p[0]} - at[0], double{p[1]} - at[1], double{p[2]} - at[2]);
          if (distance <= reach) visit(member->second, distance);
        }
      }
    }
  }

 private:
  using Key = std::array<int, 3>;
  using Member = std::pair<Key, uint32_t>;

  Key KeyOf(const std::array<float, 3>& p) const {
    Key key{};
    for (size_t axis = 0; axis < 3; ++axis) key[axis] = static_cast<int>(std::floor(p[axis] / edge_));
    return key;
  }

  const TestPoints& points_;
  const double edge_;
  std::vector<Member> members_;
};

// A cloud of which it is known whose normals are wrong.
struct WrongCloud {
  std::string name;
  TestPoints points;
  Flips flips;
  // Whether all points are of one sheet, so that normals of both sides anywhere in a neighborhood are a seam. Else two
  // points make a seam of which one is among the 6 nearest of the other, of which one alone is wrong, and whose normals
  // are more than 100 degrees apart: about a crease of 90 degrees a scan does not tell opposed normals from right ones.
  bool is_one_sheet = true;
  size_t every = 1;  // which of the estimates are tried
};

// For each point those of its 6 nearest points that make a seam with it.
std::vector<std::vector<uint32_t>> SeamPartners(const WrongCloud& cloud, const Cubes& cubes, double reach) {
  constexpr size_t kNearest = 6;
  constexpr double kOpposed = -0.17;  // the cosine of 100 degrees
  std::vector<std::vector<uint32_t>> partners(cloud.points.size());
  std::vector<std::pair<double, uint32_t>> near;
  for (uint32_t i = 0; i < cloud.points.size(); ++i) {
    near.clear();
    cubes.ForEachWithin(i, reach, [&](uint32_t j, double distance) {
      if (j != i) near.push_back({distance, j});
    });
    std::sort(near.begin(), near.end());
    for (size_t k = 0; k < std::min(kNearest, near.size()); ++k) {
      const uint32_t j = near[k].second;
      double dot = 0.0;
      for (size_t axis = 0; axis < 3; ++axis) {
        dot += double{cloud.points.normals[i][axis]} * cloud.points.normals[j][axis];
      }
      if (cloud.flips[i] != cloud.flips[j] && dot < kOpposed) partners[i].push_back(j);
    }
  }
  return partners;
}

// How many OK points have a seam within the radius of their result.
class CrossingCounter {
 public:
  CrossingCounter(const WrongCloud& cloud, double typical_reach)
      : cloud_(cloud), cubes_(cloud.points, typical_reach), is_near_(cloud.points.size()) {
    if (!cloud.is_one_sheet) partners_ = SeamPartners(cloud, cubes_, typical_reach);
  }

  size_t Count(std::span<const PointCurvature> results) {
    size_t crossing = 0;
    for (size_t i = 0; i < results.size(); ++i) {
      if (results[i].status == PointStatus::kOk && Crosses(i, results[i].radius)) ++crossing;
    }
    return crossing;
  }

 private:
  bool Crosses(size_t i, double reach) {
    near_.clear();
    cubes_.ForEachWithin(i, reach, [&](uint32_t j, double) { near_.push_back(j); });
    if (cloud_.is_one_sheet) {
      return std::any_of(near_.begin(), near_.end(), [&](uint32_t j) { return cloud_.flips[j] != cloud_.flips[i]; });
    }
    for (const uint32_t j : near_) is_near_[j] = 1;
    const bool crosses = std::any_of(near_.begin(), near_.end(), [&](uint32_t j) {
      return std::any_of(partners_[j].begin(), partners_[j].end(), [&](uint32_t k) { return is_near_[k] != 0; });
    });
    for (const uint32_t j : near_) is_near_[j] = 0;
    return crosses;
  }

  const WrongCloud& cloud_;
  const Cubes cubes_;
  std::vector<std::vector<uint32_t>> partners_;
  std::vector<uint32_t> near_;
  std::vector<char> is_near_;
};

// The points of an estimate that looks for no seam.
std::vector<PointCurvature> EstimateWithoutCheck(const TestPoints& points, const EstimatorOptions& options) {
  const SpatialIndex index = BuildIndex(points.ToCloud());
  std::vector<PointCurvature> results(points.size());
  const std::unique_ptr<StrategyRun> run = FindStrategy(options.estimator)->start(options, index, results.data());
  const std::unique_ptr<WorkerScratch> scratch = run->MakeScratch();
  scratch->seams = nullptr;
  for (const GroupPhase& phase : run->Phases()) {
    absl::Status status = phase.Begin().status();
    for (size_t group = 0; group < index.group_count() && status.ok(); ++group) {
      scratch->first_point = 0;
      do {
        scratch->rest = 0;
        status = phase.run(group, *scratch);
        scratch->first_point = scratch->rest;
      } while (status.ok() && scratch->rest > 0);
    }
    if (!status.ok()) Fail(status);
  }
  return results;
}

size_t CountOk(std::span<const PointCurvature> results) {
  return static_cast<size_t>(std::count_if(results.begin(), results.end(),
                                           [](const PointCurvature& p) { return p.status == PointStatus::kOk; }));
}

double MedianRadius(std::span<const PointCurvature> results) {
  std::vector<float> radii;
  for (const PointCurvature& point : results) radii.push_back(point.radius);
  const auto middle = radii.begin() + static_cast<std::ptrdiff_t>(radii.size() / 2);
  std::nth_element(radii.begin(), middle, radii.end());
  return *middle;
}

struct Way {
  std::string name;
  EstimatorOptions options;
};

// Every estimator by its defaults, and one by few and by many neighbors; of these each `every`th.
std::vector<Way> Ways(size_t every) {
  std::vector<Way> ways;
  for (const Strategy* strategy : Strategies()) {
    EstimatorOptions options;
    options.estimator = strategy->name;
    ways.push_back({std::string(strategy->name), options});
  }
  for (const uint32_t count : {15u, 200u}) {
    EstimatorOptions options;
    options.neighborhood = NeighborCount{count};
    ways.push_back({std::string(options.estimator) + ", K = " + std::to_string(count), options});
  }
  std::vector<Way> picked;
  for (size_t i = 0; i < ways.size(); i += every) picked.push_back(std::move(ways[i]));
  return picked;
}

std::vector<WrongCloud> WrongSpheres(size_t count) {
  std::vector<WrongCloud> clouds;
  for (const double share : {0.5, 0.1, 0.01}) {
    TestPoints points = RandomSphere(count, 1.0, 1);
    const Flips flips = FlipAtRandom(share, 2, points);
    char name[64];
    std::snprintf(name, sizeof(name), "sphere, %g %% flipped", 100.0 * share);
    clouds.push_back({name, std::move(points), flips});
  }
  for (const std::array<float, 3> axis : {std::array{0.0f, 0.0f, 1.0f}, std::array{0.5f, -0.7f, 0.6f}}) {
    TestPoints points = axis[0] == 0.0f ? Sphere(count, 1.0) : RandomSphere(count, 1.0, 3);
    const Flips flips = FlipWhere(
        [&](const std::array<float, 3>& p) { return p[0] * axis[0] + p[1] * axis[1] + p[2] * axis[2] > 0.0f; }, points);
    clouds.push_back(
        {axis[0] == 0.0f ? "sphere, a half flipped" : "sphere at random, a half flipped", std::move(points), flips});
  }
  return clouds;
}

// The points with the normals that orientation gives them, and which of them it turned.
std::pair<TestPoints, Flips> Oriented(const TestPoints& points) {
  WorkerPool pool(2);
  NormalOptions options;
  options.source = NormalSource::kOrient;
  const auto made = MakeNormals(points.ToCloud(), options, pool);
  if (!made.ok()) Fail(made.status());
  TestPoints oriented = points;
  Flips flips(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    double dot = 0.0;
    for (size_t axis = 0; axis < 3; ++axis) dot += double{made->normals[i].normal[axis]} * points.normals[i][axis];
    flips[i] = dot < 0.0 ? 1 : 0;
    if (dot < 0.0) {
      for (float& component : oriented.normals[i]) component = -component;
    }
  }
  return {std::move(oriented), std::move(flips)};
}

TestPoints Disturbed(const TestPoints& points, double noise) {
  const auto vectors = [](const std::vector<std::array<float, 3>>& from) {
    std::vector<curv::Vec3> to;
    for (const auto& v : from) to.push_back({v[0], v[1], v[2]});
    return to;
  };
  std::vector<curv::Vec3> positions = vectors(points.positions), normals = vectors(points.normals);
  curv::AddPositionNoise(noise, 1, positions);
  curv::AddNormalNoise(noise, 1, normals);
  TestPoints disturbed;
  for (size_t i = 0; i < positions.size(); ++i) {
    const curv::Vec3 &p = positions[i], &n = normals[i];
    disturbed.Add(p.x, p.y, p.z, n.x, n.y, n.z);
  }
  return disturbed;
}

TestPoints SampleSurface(const std::string& name, size_t points) {
  const auto surface = curv::MakeSurface(name);
  if (!surface.ok()) Fail(surface.status());
  const auto samples = curv::SampleEvenly(**surface, points, 1);
  if (!samples.ok()) Fail(samples.status());
  TestPoints out;
  for (const curv::Vec3& p : *samples) {
    const curv::Vec3 n = (*surface)->At(p).normal;
    out.Add(p.x, p.y, p.z, n.x, n.y, n.z);
  }
  return out;
}

std::vector<NamedPoints> RightClouds(size_t count, const std::string& shared, size_t every) {
  std::vector<NamedPoints> clouds;
  for (const std::string surface : {"goursat", "torus"}) {
    const TestPoints made = SampleSurface(surface, count);
    for (const double noise : {0.0, 0.2}) {
      clouds.push_back({surface + (noise > 0.0 ? ", noise 0.2" : ""), Disturbed(made, noise)});
    }
    if (auto points = LoadPoints(shared + "/data/paper/" + surface + "_025000.pts")) {
      clouds.push_back({surface + " of the paper", *std::move(points), every});
    }
  }
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    clouds.push_back({"plate of 2 spacings", Plate(count, 2.0, seed)});
    clouds.push_back({"gap of 2 spacings", Plate(count, -2.0, seed)});
    clouds.push_back({"shell of 2 spacings", Shell(count, 2.0, seed)});
    clouds.push_back({"lens of 4 spacings", Lens(count, 4.0, seed)});
  }
  return clouds;
}

// Prints one cloud's row of each way. Returns how many points are OK although their neighborhoods cross a seam.
size_t ReportWrong(const WrongCloud& cloud) {
  size_t total = 0;
  for (const Way& way : Ways(cloud.every)) {
    const std::vector<PointCurvature> without = EstimateWithoutCheck(cloud.points, way.options);
    const EstimationResult with = MustEstimate(cloud.points.ToCloud(), way.options);
    CrossingCounter counter(cloud, MedianRadius(without));
    const size_t crossing = counter.Count(with.field.points.span());
    const NormalsAgreement& agreement = with.agreement;
    const double opposed = static_cast<double>(agreement.opposed_pairs);
    std::printf("%-34s %-22s %8zu %8zu %8zu %8zu %8.2f %8zu %s\n", cloud.name.c_str(), way.name.c_str(),
                CountOk(without), counter.Count(without), CountOk(with.field.points.span()), crossing,
                100.0 * opposed / static_cast<double>(std::max<uint64_t>(agreement.near_pairs, 1)),
                static_cast<size_t>(agreement.flipped_patches),
                crossing > 0                   ? "CROSSES"
                : agreement.opposed_pairs == 0 ? "NO WARNING"
                                               : "");
    std::fflush(stdout);
    total += crossing + (agreement.opposed_pairs == 0 ? 1 : 0);
  }
  return total;
}

// Prints one row. Returns how many points differ in some byte.
size_t ReportRight(const NamedPoints& cloud) {
  size_t total = 0;
  for (const Way& way : Ways(cloud.every)) {
    const std::vector<PointCurvature> without = EstimateWithoutCheck(cloud.points, way.options);
    const EstimationResult with = MustEstimate(cloud.points.ToCloud(), way.options);
    size_t differing = 0;
    for (size_t i = 0; i < without.size(); ++i) {
      differing += FirstDifference({&without[i], 1}, {&with.field.points[i], 1}) == 0 ? 1 : 0;
    }
    if (differing > 0) std::printf("%s, %s: %zu points differ\n", cloud.name.c_str(), way.name.c_str(), differing);
    total += differing + with.agreement.opposed_pairs;
  }
  std::printf("%-34s %8zu points %3zu estimates %8zu differ\n", cloud.name.c_str(), cloud.points.size(),
              Ways(cloud.every).size(), total);
  std::fflush(stdout);
  return total;
}

int Main(size_t count, const std::string& shared, size_t every) {
  std::vector<WrongCloud> wrong = WrongSpheres(count);
  std::vector<NamedPoints> right = RightClouds(count / 2, shared, every);
  if (auto scan = LoadPoints(shared + "/data/scans/armadillo100k.ply")) {
    auto [oriented, flips] = Oriented(*scan);
    right.push_back({"armadillo100k, oriented", std::move(oriented), every});
    wrong.push_back({"armadillo100k, as it is on disk", *std::move(scan), std::move(flips), false, every});
  }
  std::printf("%-34s %-22s %8s %8s %8s %8s %8s %8s\n", "wrong normals", "estimator", "OK, no", "of these", "OK",
              "of these", "opposed", "flipped");
  std::printf("%-34s %-22s %8s %8s %8s %8s %8s %8s\n", "", "", "check", "crossing", "", "crossing", "pairs, %",
              "patches");
  size_t failures = 0;
  for (const WrongCloud& cloud : wrong) failures += ReportWrong(cloud);
  std::printf("\nright normals\n");
  for (const NamedPoints& cloud : right) failures += ReportRight(cloud);
  std::printf("\n%zu clouds with wrong normals, %zu with right ones: %s\n", wrong.size(), right.size(),
              failures == 0 ? "no OK point crosses a seam, and no byte differs" : "FAILED");
  return failures == 0 ? 0 : 1;
}

}  // namespace
}  // namespace curvd::testing

int main(int argc, char** argv) {
  const long count = argc >= 2 && argc <= 4 ? std::atol(argv[1]) : 0, every = argc == 4 ? std::atol(argv[3]) : 1;
  if (count < 1000 || count > 1'000'000 || every < 1) {
    std::fprintf(stderr,
                 "usage: seam_errors POINTS [SHARED_DIR [EVERY]], of 1000 to 1000000 points, EVERY from 1 on\n");
    return 2;
  }
  return curvd::testing::Main(static_cast<size_t>(count), argc >= 3 ? argv[2] : "", static_cast<size_t>(every));
}
