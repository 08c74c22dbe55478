// Clouds for the core's tests: even and nasty ones, reproducible by seed.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/cloud/cloud.h"
#include "core/index/spatial_index.h"
#include "core/job/estimation_job.h"

namespace curvd::testing {

struct TestPoints {
  std::vector<std::array<float, 3>> positions;
  std::vector<std::array<float, 3>> normals;

  void Add(double x, double y, double z, double nx, double ny, double nz);
  size_t size() const { return positions.size(); }
  // In float32, invalid points kept (kSkip). One that expected its points has them in one array.
  enum class Size { kExpected, kUnknown };
  Cloud ToCloud(Size size = Size::kExpected) const;
};

// A sphere of the given radius around the origin, evenly spread, outward normals.
TestPoints Sphere(size_t points, double radius);

// Points at random on a pipe of radius 0.5 and length 20 along an axis askew to the coordinates: of 1,500 points, 12
// lie around it. Exact outward normals.
TestPoints Pipe(size_t points, uint64_t seed);

// The graph of a wavy function over the unit square, its samples random and moved by `noise` in every direction. Exact
// normals point up; the largest curvature is 4.
TestPoints Waves(size_t points, double noise, uint64_t seed);

// The kinds of cloud that a search must survive.
enum class Layout { kUniform, kClustered, kCollinear, kCoplanar, kDuplicates, kLattice, kAnisotropic, kOutlier };
inline constexpr Layout kLayouts[] = {Layout::kUniform,    Layout::kClustered, Layout::kCollinear,   Layout::kCoplanar,
                                      Layout::kDuplicates, Layout::kLattice,   Layout::kAnisotropic, Layout::kOutlier};
std::string LayoutName(Layout layout);

// Points of a layout with random unit normals around +z.
TestPoints RandomPoints(Layout layout, size_t points, uint64_t seed);

// The index of a cloud.
SpatialIndex BuildIndex(Cloud cloud);

// The names of all estimators.
inline constexpr std::string_view kEstimators[] = {"avg-hexagram", "hexagram", "uniform", "independent",
                                                   "delaunay",     "jet",      "aso",     "normal-regression"};

// Estimates with `threads` threads; fails the test on error.
EstimationResult MustEstimate(Cloud cloud, const EstimatorOptions& options, int threads = 2);

// The first point whose results differ in a bit of a column, or the number of points if none does.
// REQUIRES: as many points in both.
size_t FirstDifference(std::span<const PointCurvature> a, std::span<const PointCurvature> b);

}  // namespace curvd::testing
