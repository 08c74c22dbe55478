// What the strategies that fit surfaces keep for each worker.
#pragma once

#include <algorithm>
#include <cstddef>

#include "core/estimators/fits/fit_columns.h"
#include "core/estimators/fits/group_shapes.h"
#include "core/estimators/fits/jet_least_squares.h"
#include "core/estimators/fits/jet_systems.h"
#include "core/estimators/fits/linear_systems.h"
#include "core/estimators/fits/regression_systems.h"
#include "core/estimators/fits/sphere_sums.h"
#include "core/estimators/group_scratch.h"
#include "core/estimators/neighborhood_plan.h"
#include "core/estimators/neighbors/neighbors.h"

namespace curvd {

// `System` is what a fit sums over the neighbors of each point.
template <typename System>
struct FitScratch : GroupScratch {
  NeighborArrays neighbors;  // of the point of the moment
  FitColumns columns;        // of the same
  System system{};           // of each point of the group
  GroupShapes shapes{};      // of each point of the group, once all are solved

  size_t bytes() const override { return sizeof(*this) + search.bytes() + neighbors.bytes() + columns.bytes(); }
  // `column_count`: columns that the fit uses at most, each of up to `most_in_columns` neighbors.
  static size_t MostBytes(const EstimatorOptions& options, size_t point_count, size_t column_count = 0,
                          size_t most_in_columns = 0) {
    const size_t most = MostNeighbors(options, point_count);
    return sizeof(FitScratch) + SearchScratchBytes(SearchSizes(options), point_count) +
           NeighborArrays::MostBytes(most) + FitColumns::MostBytes(column_count, std::min(most, most_in_columns));
  }
};

struct JetScratch : FitScratch<JetSystems> {
  ScratchArray<double> qr_room;  // of SolveJetByQr

  size_t bytes() const override { return FitScratch::bytes() - sizeof(FitScratch) + sizeof(*this) + qr_room.bytes(); }
  static size_t MostBytes(const EstimatorOptions& options, size_t point_count) {
    const auto degree = static_cast<int>(options.jet_degree);
    return FitScratch::MostBytes(options, point_count, JetColumnCount(degree), kMostInJetColumns) - sizeof(FitScratch) +
           sizeof(JetScratch) + JetQrBytes(MostNeighbors(options, point_count), degree);
  }
};
using SphereScratch = FitScratch<SphereSums>;
using RegressionScratch = FitScratch<RegressionSystems>;
using LinearScratch = FitScratch<LinearSystems>;

struct JetPlan {
  JetPlan(const EstimatorOptions& options, const SpatialIndex& index)
      : neighborhood(NeighborhoodPlan::Make(options, index)), degree(static_cast<int>(options.jet_degree)) {}

  NeighborhoodPlan neighborhood;
  int degree;
};

struct SpherePlan {
  SpherePlan(const EstimatorOptions& options, const SpatialIndex& index)
      : neighborhood(NeighborhoodPlan::Make(options, index)), project(options.project) {}

  NeighborhoodPlan neighborhood;
  bool project;
};

struct RegressionPlan {
  RegressionPlan(const EstimatorOptions& options, const SpatialIndex& index)
      : neighborhood(NeighborhoodPlan::Make(options, index)), degree(static_cast<int>(options.regression_degree)) {}

  NeighborhoodPlan neighborhood;
  int degree;
};

}  // namespace curvd
