// What one thread fits normals with.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>

#include "core/estimators/fits/fit_scratch.h"
#include "core/estimators/group_scratch.h"
#include "core/index/spatial_index.h"
#include "core/normals/normal_fit.h"

namespace curvd {

// The fit of one point of a group, as long as what it was solved from is known.
struct FittedPoint {
  size_t point;   // of the group, or of its sample
  size_t system;  // which of NormalScratch::system, with its radius in NormalScratch::frames
  double u, v;    // where in that system's frame the polynomial is read, in units of rho
  std::array<double, 3> normal;
  double mean_square;  // as NormalScratch has it
};

// The neighbors of as many points as vectors have lanes, as offsets: the j-th of the point in lane l at j times the
// number of lanes, plus l.
struct alignas(64) LaneNeighbors {
  static constexpr size_t kMostNeighbors = 64;
  static constexpr size_t kRoom = kMostNeighbors * SpatialIndex::kLeafSize / 2;
  float x[kRoom], y[kRoom], z[kRoom];
  double in_frame[3][kRoom];  // the same in the frames of the points, in units of rho
};

// What points that share polynomials get.
struct SharedFits {
  GroupPoints members;
  size_t leaf_of[SpatialIndex::kGroupPoints];  // of each member: which of the group's leaves with members
  GroupDoubleVectors normal;
  GroupDoubles mean_square, variance_ratio;
};

// What one thread fits normals with: a group of points at a time.
struct NormalScratch : JetScratch {
  // Of each point of the group whose status is kOk:
  GroupDoubleVectors normal{};              // of unit length
  GroupDoubles mean_square{};               // distance of the neighbors from the fit, squared, in units of rho
  GroupDoubles variance_ratio{};            // as PointNormal has it
  GroupDoubles breadth{};                   // middle variance of the neighbors' positions over the widest: 0 a line
  bool is_rim[SpatialIndex::kGroupPoints];  // whether `normal` is that of a rim (NormalFit::two_sheets)
  GroupDoubles mean_square_height{};        // of the neighbors along the axis of least spread, in units of rho
  // If not empty, called once the neighbors of point i of a sample and its frame are known.
  std::function<void(size_t i)> inspect{};
  // If not empty, called for each point whose status is kOk once its polynomial is solved.
  std::function<void(const FittedPoint& fitted)> take{};
  LaneNeighbors lanes{};
  SharedFits shared{};            // of the group of the moment, where points share fits
  bool is_noisy = false;          // whether the group was fitted as the noisy part is
  uint64_t chosen = kAllOfGroup;  // which points of a group are fitted, a bit for each place

  static constexpr uint64_t kAllOfGroup = ~uint64_t{0};

  size_t bytes() const override { return JetScratch::bytes() - sizeof(JetScratch) + sizeof(*this); }
  static size_t MostBytes(const NormalFit& fit, size_t point_count) {
    return JetScratch::MostBytes(fit.ToEstimatorOptions(), point_count) - sizeof(JetScratch) + sizeof(NormalScratch);
  }
};

}  // namespace curvd
