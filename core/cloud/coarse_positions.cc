#include "core/cloud/coarse_positions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

namespace curvd {
namespace {

constexpr size_t kLeastPoints = 100;
// A prime, so that the samples of large clouds lie in no step with the rows of a scanner.
constexpr size_t kMostSampled = 4093;
// Points at zero, or far away, are no part of what was scanned.
constexpr double kOuterShare = 0.05;
// Rounding by this share of the distance between points is noise of a hundredth of a neighborhood's radius at most.
constexpr double kCoarse = 0.125;

struct Extent {
  double length = 0.0;    // between the quantiles, taken up to the whole
  double farthest = 0.0;  // from zero
};

Extent ExtentOf(std::span<float> values) {
  const auto outer = static_cast<std::ptrdiff_t>(kOuterShare * static_cast<double>(values.size()));
  const auto low = values.begin() + outer, high = values.end() - 1 - outer;
  std::nth_element(values.begin(), low, values.end());
  std::nth_element(low + 1, high, values.end());
  return {(double{*high} - *low) / (1.0 - 2.0 * kOuterShare),
          std::max(std::abs(double{*low}), std::abs(double{*high}))};
}

// The distance between floats that are that far from zero.
double StepAt(double farthest) {
  const auto at = static_cast<float>(farthest);
  return double{at} - std::nextafter(at, 0.0f);
}

}  // namespace

std::optional<CoarsePositions> FindCoarsePositions(const Cloud& cloud) {
  if (cloud.scalar_type() != ScalarType::kFloat32 || cloud.lattice_spacing() > 0.0) return std::nullopt;
  const size_t samples = std::min(cloud.size(), kMostSampled);
  std::array<double, 3> lengths{};
  double farthest = 0.0;
  for (size_t axis = 0; axis < 3; ++axis) {
    std::array<float, kMostSampled> values;
    size_t count = 0;
    for (size_t k = 0; k < samples; ++k) {
      const float value = cloud.position(k * cloud.size() / samples)[axis];
      if (std::isfinite(value)) values[count++] = value;  // no value of an invalid point is
    }
    if (count < kLeastPoints) return std::nullopt;
    const Extent extent = ExtentOf(std::span(values).first(count));
    lengths[axis] = extent.length;
    farthest = std::max(farthest, extent.farthest);
  }
  std::sort(lengths.begin(), lengths.end());
  const double points = static_cast<double>(cloud.size());
  const double spacing = std::max(std::sqrt(lengths[2] / points * lengths[1]), lengths[2] / points);
  const double step = StepAt(farthest);
  if (!(spacing > 0.0) || step < kCoarse * spacing) return std::nullopt;
  return CoarsePositions{farthest, step, spacing};
}

}  // namespace curvd
