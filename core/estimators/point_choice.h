// How the estimate of a point was chosen, and how sure it is: what an automatic estimate returns beside curvature.
#pragma once

#include <array>
#include <cstddef>
#include <limits>

#include "core/base/page_array.h"
#include "core/estimators/curvature_field.h"

namespace curvd {

// All values are NaN where the status of the point's curvature is not kOk, and beside a sharp edge where no fit of the
// point's own side was found.
struct PointChoice {
  // Standard errors of H, k1 and k2, in 1 / the caller's length unit: nine in ten of the intervals H - 1.645 mean_error
  // to H + 1.645 mean_error hold the truth, and likewise for k1 and k2 (docs/numerics/standard_errors.md tells where
  // fewer or more do). NaN where the sample of the cloud is too small to tell, beside seams that took over a tenth of
  // the weights, and, where normals were made of noisy positions, for estimates that are not by jets alone, unless
  // there are normals of halves (core/normals/runs/half_normals.h).
  float mean_error;
  float k1_error;
  float k2_error;
  // Points in a neighborhood: the mean of those that were averaged, by their weights in H.
  float neighbor_count;
  // How much each estimator counts in H; the sum is 1. G, and k2 - k1 with its directions, may have other weights.
  float avg_hexagram_weight;
  float normal_regression_weight;
  float jet_weight;
  float aso_weight;
};

// Every column of choices, with offsets in PointChoice; as kColumns has them of curvature.
inline constexpr std::array kChoiceColumns = {
    Column{"mean_curvature_standard_error", ColumnType::kFloat32, 1, offsetof(PointChoice, mean_error)},
    Column{"k1_standard_error", ColumnType::kFloat32, 1, offsetof(PointChoice, k1_error)},
    Column{"k2_standard_error", ColumnType::kFloat32, 1, offsetof(PointChoice, k2_error)},
    Column{"chosen_neighbor_count", ColumnType::kFloat32, 1, offsetof(PointChoice, neighbor_count)},
    Column{"avg_hexagram_weight", ColumnType::kFloat32, 1, offsetof(PointChoice, avg_hexagram_weight)},
    Column{"normal_regression_weight", ColumnType::kFloat32, 1, offsetof(PointChoice, normal_regression_weight)},
    Column{"jet_weight", ColumnType::kFloat32, 1, offsetof(PointChoice, jet_weight)},
    Column{"aso_weight", ColumnType::kFloat32, 1, offsetof(PointChoice, aso_weight)},
};

// A value whose every float is NaN.
inline constexpr PointChoice UndefinedChoice() {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  return {kNaN, kNaN, kNaN, kNaN, kNaN, kNaN, kNaN, kNaN};
}

// In the order of the points in the cloud; of those that get a result.
using ChoiceField = PageArray<PointChoice>;

}  // namespace curvd
