// How far an estimate is from the truth, by the measures of the paper and of the peers' tables.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "client/surfaces/surface.h"
#include "core/estimators/curvature_field.h"

namespace curvd::bench {

// Of the absolute errors of one quantity.
struct QuantityErrors {
  double mean;
  double rms;
  double lower_quartile;
  double median;
  double upper_quartile;
};

// NaN throughout if no point was estimated.
struct FieldErrors {
  QuantityErrors mean;      // H
  QuantityErrors gaussian;  // G
  QuantityErrors k1;
  QuantityErrors k2;
  double direction_median;  // degrees between the estimated and the true d1, as lines
  size_t estimated;         // points with status ok; only these count
  size_t failed;            // the others
};

// REQUIRES: field and truth are equally long.
FieldErrors MeasureErrors(std::span<const PointCurvature> field, std::span<const curv::SurfaceGeometry> truth);

}  // namespace curvd::bench
