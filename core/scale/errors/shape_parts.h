// Shape operators at sampled points: their weighted means, and what their changes are made of.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/estimators/scale_ladder.h"
#include "core/scale/pilot/pilot_table.h"
#include "core/scale/shapes/tangent_shape.h"

namespace curvd {

// Parts of a change of the shape operator, in the axes of its principal directions: the change of H, of k1, of k2, and
// what turns the directions and, near an umbilic point, drives k1 and k2 apart.
enum ShapePart : uint8_t { kMeanPart, kFirstPart, kSecondPart, kTurnPart };
inline constexpr size_t kShapeParts = 4;
using ShapeParts = std::array<double, kShapeParts>;

inline TangentShape operator-(const TangentShape& a, const TangentShape& b) {
  return {a.mean - b.mean, a.difference - b.difference, a.twist - b.twist};
}

inline bool IsFinite(const TangentShape& shape) { return std::isfinite(shape.mean + shape.difference + shape.twist); }

// What a candidate estimates at a sampled point, from all neighbors or from a half of them; NaN where it has none.
inline TangentShape EstimateAt(const PilotPoint& point, const ScaleCandidate& candidate, PilotPoint::Part part) {
  const auto value = [&](const PilotPoint::Estimates& estimates) {
    return double{estimates[candidate.method][candidate.rung][part]};
  };
  return {value(point.mean), value(point.difference), value(point.twist)};
}

// Whether both halves have an estimate.
inline bool HasHalves(const PilotPoint& point, const ScaleCandidate& candidate) {
  return IsFinite(EstimateAt(point, candidate, PilotPoint::kEven)) &&
         IsFinite(EstimateAt(point, candidate, PilotPoint::kOdd));
}

// How much an estimate counts: half the trace of its shape operator, and the rest.
struct ShapeWeight {
  double mean = 0.0, traceless = 0.0;

  void operator+=(const ShapeWeight& other) {
    mean += other.mean;
    traceless += other.traceless;
  }
  bool IsPositive() const { return mean > 0.0 && traceless > 0.0; }
};

inline TangentShape operator*(const ShapeWeight& factor, const TangentShape& shape) {
  return {factor.mean * shape.mean, factor.traceless * shape.difference, factor.traceless * shape.twist};
}

// A weighted mean of shape operators.
struct ShapeSum {
  TangentShape sum{};
  ShapeWeight weight;

  void Add(const TangentShape& shape, const ShapeWeight& w) {
    const TangentShape weighted = w * shape;
    sum = {sum.mean + weighted.mean, sum.difference + weighted.difference, sum.twist + weighted.twist};
    weight += w;
  }
  // REQUIRES: weight.IsPositive().
  TangentShape Mean() const { return ShapeWeight{1.0 / weight.mean, 1.0 / weight.traceless} * sum; }
};

// The axes of the principal directions: cosine and sine of twice the angle from the frame's x to the direction of k2.
struct PrincipalAxes {
  explicit PrincipalAxes(const TangentShape& shape) {
    const double r = std::hypot(shape.difference, shape.twist);
    if (!(r > 0.0)) return;
    cosine = shape.difference / r;
    sine = shape.twist / r;
  }
  ShapeParts PartsOf(const TangentShape& change) const {
    const double along = cosine * change.difference + sine * change.twist;
    return {change.mean, change.mean - along, change.mean + along, cosine * change.twist - sine * change.difference};
  }
  double cosine = 1.0, sine = 0.0;
};

}  // namespace curvd
