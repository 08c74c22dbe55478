// What callers and the core call each estimator.
#pragma once

#include <array>

#include "core/estimators/options.h"
#include "curvature/v1/curvature.pb.h"

namespace curvd {

struct WireEstimator {
  curvature::v1::Estimator proto;
  EstimatorKind kind;
};

// Every strategy that this server knows, in the order of the proto, the default first.
inline constexpr std::array<WireEstimator, 7> kWireEstimators = {{
    {curvature::v1::ESTIMATOR_AVG_HEXAGRAM, EstimatorKind::kAvgHexagram},
    {curvature::v1::ESTIMATOR_HEXAGRAM, EstimatorKind::kHexagram},
    {curvature::v1::ESTIMATOR_UNIFORM, EstimatorKind::kUniform},
    {curvature::v1::ESTIMATOR_INDEPENDENT, EstimatorKind::kIndependent},
    {curvature::v1::ESTIMATOR_DELAUNAY, EstimatorKind::kDelaunay},
    {curvature::v1::ESTIMATOR_JET_FITTING, EstimatorKind::kJetFitting},
    {curvature::v1::ESTIMATOR_ALGEBRAIC_SHAPE_OPERATOR, EstimatorKind::kAlgebraicShapeOperator},
}};

}  // namespace curvd
