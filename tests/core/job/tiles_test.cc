// The results of a cloud that is cut into tiles are those of the whole cloud, to the last bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "core/cloud/cloud.h"
#include "core/estimators/strategies.h"
#include "core/job/estimation_job.h"
#include "tests/core/instruction_sets.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

template <typename Scalar>
struct Scene {
  std::vector<std::array<Scalar, 3>> positions;
  std::vector<std::array<Scalar, 3>> normals;

  size_t size() const { return positions.size(); }
  void Add(double x, double y, double z, double by_x, double by_y) {
    positions.push_back({static_cast<Scalar>(x), static_cast<Scalar>(y), static_cast<Scalar>(z)});
    normals.push_back({static_cast<Scalar>(-by_x), static_cast<Scalar>(-by_y), Scalar{1}});
  }
};

constexpr double kSide = 100.0;

// A hilly square whose density falls with the distance from a corner, far from zero, with some points twice and a part
// on a grid, where distances tie.
template <typename Scalar>
Scene<Scalar> Hills(size_t points, std::array<double, 3> far) {
  Scene<Scalar> scene;
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::normal_distribution<double> noise(0.0, 0.02);
  const auto add = [&](double x, double y) {
    const double z = 3.0 * std::sin(x / 9.0) * std::cos(y / 7.0);
    scene.Add(x + far[0], y + far[1], z + far[2] + noise(random),
              std::cos(x / 9.0) * std::cos(y / 7.0) / 3.0 + noise(random),
              -3.0 / 7.0 * std::sin(x / 9.0) * std::sin(y / 7.0) + noise(random));
  };
  while (scene.size() < points) {
    const double u = unit(random), v = unit(random);
    if (unit(random) > 1.0 / (1.0 + 4.0 * (u * u + v * v))) continue;
    add(kSide * u, kSide * v);
    if (scene.size() % 50 == 0)
      scene.Add(scene.positions.back()[0], scene.positions.back()[1], scene.positions.back()[2], 0, 0);
  }
  for (int i = 0; i < 30; ++i) {
    for (int j = 0; j < 30; ++j) scene.Add(40 + i + far[0], 40 + j + far[1], 20 + far[2], 0, 0);
  }
  return scene;
}

template <typename Scalar>
Cloud MakeCloud(const Scene<Scalar>& scene, const std::vector<size_t>& chosen, const std::vector<PointRole>& roles,
                std::optional<Lattice> lattice) {
  std::vector<std::array<Scalar, 3>> positions, normals;
  std::vector<uint64_t> ids;
  for (const size_t i : chosen) {
    positions.push_back(scene.positions[i]);
    normals.push_back(scene.normals[i]);
    ids.push_back(1'000'000'000'000 + 3 * i);
  }
  Cloud cloud(sizeof(Scalar) == sizeof(float) ? ScalarType::kFloat32 : ScalarType::kFloat64);
  if (lattice.has_value()) cloud.PlaceOn(*lattice);
  const auto bytes = [](const auto& v) {
    return std::string_view(reinterpret_cast<const char*>(v.data()), v.size() * sizeof(v[0]));
  };
  EXPECT_TRUE(cloud.AppendPart(bytes(positions), bytes(normals), ids, roles).ok());
  EXPECT_TRUE(cloud.Finish().ok());
  return cloud;
}

// A square of the ground, open to the outside of the scene.
struct Square {
  double lo[2], hi[2];

  Square Widened(double by) const { return {{lo[0] - by, lo[1] - by}, {hi[0] + by, hi[1] + by}}; }
  // From a place inside to the outside.
  double Depth(double x, double y) const { return std::min({x - lo[0], hi[0] - x, y - lo[1], hi[1] - y}); }
};

std::vector<Square> Cut(int parts, std::array<double, 3> far) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto side = [&](int i, double origin) {
    return i == 0 ? -kInfinity : i == parts ? kInfinity : origin + kSide * i / parts;
  };
  std::vector<Square> squares;
  for (int x = 0; x < parts; ++x) {
    for (int y = 0; y < parts; ++y) {
      squares.push_back({{side(x, far[0]), side(y, far[1])}, {side(x + 1, far[0]), side(y + 1, far[1])}});
    }
  }
  return squares;
}

bool SameCurvature(const PointCurvature& a, const PointCurvature& b) {
  return std::memcmp(&a, &b, offsetof(PointCurvature, status) + sizeof(PointStatus)) == 0;
}

// Estimates the scene whole and in tiles whose points come in random order, and compares the points whose tile holds
// all that their estimate may have looked at.
template <typename Scalar>
void ExpectSameBytes(const Scene<Scalar>& scene, const EstimatorOptions& options, int parts, double halo,
                     std::array<double, 3> far, std::optional<double> spacing) {
  const auto lattice = [&](const Square& square) -> std::optional<Lattice> {
    if (!spacing.has_value()) return std::nullopt;
    Lattice made{*spacing, far};
    for (int axis = 0; axis < 2; ++axis) {
      const double near = std::isfinite(square.lo[axis]) ? square.lo[axis] : square.hi[axis];
      made.origin[axis] = std::isfinite(near) ? near : far[axis];
    }
    for (double& v : made.origin) v = std::nearbyint(v / *spacing) * *spacing;
    return made;
  };
  std::vector<size_t> all(scene.size());
  std::iota(all.begin(), all.end(), size_t{0});
  const Square everything = Cut(1, far).front();
  const EstimationResult whole = MustEstimate(MakeCloud(scene, all, {}, lattice(everything)), options);
  const double reach = *ReachFactor(options);
  std::mt19937_64 random(11);
  size_t certified = 0;
  for (const Square& square : Cut(parts, far)) {
    const Square kept = square.Widened(halo);
    std::vector<size_t> chosen;
    for (size_t i = 0; i < scene.size(); ++i) {
      if (kept.Depth(scene.positions[i][0], scene.positions[i][1]) >= 0.0) chosen.push_back(i);
    }
    std::shuffle(chosen.begin(), chosen.end(), random);
    std::vector<PointRole> roles;
    std::vector<size_t> queries;
    for (const size_t i : chosen) {
      const double x = scene.positions[i][0], y = scene.positions[i][1];
      const bool is_inside = x >= square.lo[0] && x < square.hi[0] && y >= square.lo[1] && y < square.hi[1];
      roles.push_back(is_inside ? PointRole::kQuery : PointRole::kHalo);
      if (is_inside) queries.push_back(i);
    }
    const EstimationResult tile = MustEstimate(MakeCloud(scene, chosen, roles, lattice(square)), options);
    ASSERT_EQ(tile.field.points.size(), queries.size());
    for (size_t q = 0; q < queries.size(); ++q) {
      const auto& position = scene.positions[queries[q]];
      // Snapping moves a point by half a spacing.
      const double depth = kept.Depth(position[0], position[1]) - 2 * spacing.value_or(0.0);
      if (!(reach * tile.field.points[q].radius * (1 + 1e-6) < depth)) continue;
      ++certified;
      ASSERT_TRUE(SameCurvature(tile.field.points[q], whole.field.points[queries[q]]))
          << options.estimator << ", point " << queries[q] << ": mean " << tile.field.points[q].mean << " in its tile, "
          << whole.field.points[queries[q]].mean << " in the whole, status "
          << static_cast<int>(tile.field.points[q].status) << " and "
          << static_cast<int>(whole.field.points[queries[q]].status);
    }
  }
  // The halo is chosen so that nearly all are.
  EXPECT_GT(certified, scene.size() * 9 / 10);
}

struct Case {
  std::string_view estimator;
  uint32_t count;
  uint32_t jet_degree = 2;
  uint32_t regression_degree = 3;
};
constexpr Case kCases[] = {{"avg-hexagram", 15},
                           {"avg-hexagram", 50},
                           {"avg-hexagram", 600},
                           {"hexagram", 30},
                           {"hexagram", 90},
                           {"uniform", 20},
                           {"uniform", 150},
                           {"independent", 60},
                           {"delaunay", 31},
                           {"delaunay", 50},
                           {"jet", 20},
                           {"jet", 40, 4},
                           {"aso", 40},
                           {"normal-regression", 60},
                           {"normal-regression", 300},
                           {"normal-regression", 80, 2, 1}};

EstimatorOptions OptionsOf(const Case& one) {
  EstimatorOptions options;
  options.estimator = one.estimator;
  options.neighborhood = NeighborCount{one.count};
  options.jet_degree = one.jet_degree;
  options.regression_degree = one.regression_degree;
  return options;
}

// So that a neighborhood of `count` of the scene's points, times the reach, fits in.
double HaloFor(const Case& one, size_t points) {
  const double reach = *ReachFactor(OptionsOf(one));
  return 2.5 * reach * kSide * std::sqrt(one.count / (3.14 * static_cast<double>(points)));
}

class TilesTest : public InstructionSetTest {};
INSTANTIATE_TEST_SUITE_P(InstructionSets, TilesTest, InstructionSets(), InstructionSetName);

constexpr size_t kHillPoints = 6'000;
constexpr std::array<double, 3> kNear = {0, 0, 0}, kFar = {432'000.5, 5'300'000.25, 812.125};

TEST_P(TilesTest, OnALatticeHaveTheBytesOfTheWhole) {
  const Scene<double> scene = Hills<double>(kHillPoints, kFar);
  for (const Case& one : kCases) {
    ExpectSameBytes(scene, OptionsOf(one), 2, HaloFor(one, kHillPoints), kFar, 0x1p-9);
    if (HasFatalFailure()) return;
  }
}

TEST_P(TilesTest, OfFloatsHaveTheBytesOfTheWhole) {
  const Scene<float> scene = Hills<float>(kHillPoints, kNear);
  for (const Case& one : kCases) {
    ExpectSameBytes(scene, OptionsOf(one), 2, HaloFor(one, kHillPoints), kNear, std::nullopt);
    if (HasFatalFailure()) return;
  }
}

TEST_P(TilesTest, ByRadiusHaveTheBytesOfTheWhole) {
  const Scene<float> scene = Hills<float>(kHillPoints, kNear);
  for (const std::string_view estimator : {"avg-hexagram", "hexagram", "jet", "aso", "normal-regression", "uniform"}) {
    EstimatorOptions options;
    options.estimator = estimator;
    options.neighborhood = NeighborRadius{5.0};
    ExpectSameBytes(scene, options, 3, 8.0, kNear, std::nullopt);
    if (HasFatalFailure()) return;
  }
}

}  // namespace
}  // namespace curvd::testing
