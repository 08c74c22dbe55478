#include "client/cli/files/coarse_positions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <variant>
#include <vector>

#include "absl/strings/str_format.h"

namespace curv {
namespace {

constexpr size_t kLeastPoints = 100, kMostSampled = 4096;
// Points at zero, or far away, are no part of what was scanned.
constexpr double kOuterShare = 0.05;
// Rounding by this share of the distance between points is noise of a hundredth of a neighborhood's radius at most.
constexpr double kCoarse = 0.125;

struct Extent {
  double length = 0.0;    // between the quantiles, taken up to the whole
  double farthest = 0.0;  // from zero
};

Extent ExtentOf(std::vector<float> values) {
  const auto outer = static_cast<std::ptrdiff_t>(kOuterShare * static_cast<double>(values.size()));
  const auto low = values.begin() + outer, high = values.end() - 1 - outer;
  std::nth_element(values.begin(), low, values.end());
  std::nth_element(low, high, values.end());
  return {(double{*high} - *low) / (1.0 - 2.0 * kOuterShare),
          std::max(std::abs(double{*low}), std::abs(double{*high}))};
}

// The distance between floats that are that far from zero.
double StepAt(double farthest) {
  const auto at = static_cast<float>(farthest);
  return double{std::nextafter(at, std::numeric_limits<float>::infinity())} - at;
}

}  // namespace

std::string NoteOnCoarsePositions(const OrientedCloud& cloud) {
  const auto* floats = std::get_if<PackedCloud<float>>(&cloud);
  if (floats == nullptr) return "";
  const size_t points = floats->positions.size() / 3;
  const size_t stride = std::max<size_t>(1, points / kMostSampled);
  std::array<std::vector<float>, 3> axes;
  for (size_t i = 0; i < points; i += stride) {
    const float* const p = &floats->positions[3 * i];
    if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2])) continue;
    for (size_t axis = 0; axis < 3; ++axis) axes[axis].push_back(p[axis]);
  }
  if (axes[0].size() < kLeastPoints) return "";
  std::array<double, 3> lengths{};
  double farthest = 0.0;
  for (size_t axis = 0; axis < 3; ++axis) {
    const Extent extent = ExtentOf(std::move(axes[axis]));
    lengths[axis] = extent.length;
    farthest = std::max(farthest, extent.farthest);
  }
  std::sort(lengths.begin(), lengths.end());
  const double count = static_cast<double>(points);
  const double between = std::max(std::sqrt(lengths[2] / count * lengths[1]), lengths[2] / count);
  const double step = StepAt(farthest);
  if (!(between > 0.0) || step < kCoarse * between) return "";
  return absl::StrFormat(
      "positions are floats near %.3g, which lie %.2g apart there, and the points about %.2g: curvature will be that "
      "of "
      "the rounding. Write doubles, or subtract an origin before the coordinates become floats",
      farthest, step, between);
}

}  // namespace curv
