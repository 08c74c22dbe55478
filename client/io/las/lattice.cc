#include "client/io/las/lattice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <type_traits>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "client/io/text.h"

namespace curv {
namespace {

constexpr double kLeastStep = std::numeric_limits<int32_t>::min();
constexpr double kMostStep = std::numeric_limits<int32_t>::max();

// The step as a double, which may be out of range.
double RawStep(const LasAxis& axis, double value) { return std::nearbyint((value - axis.offset) / axis.scale); }

bool IsStep(double step) { return step >= kLeastStep && step <= kMostStep; }

struct Extent {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
};

absl::StatusOr<Extent> ExtentOf(const Column& column) {
  Extent extent;
  for (size_t i = 0; i < column.size(); ++i) {
    const double value = column.At(i);
    if (!std::isfinite(value)) {
      return absl::InvalidArgumentError(absl::StrCat("point ", i, " has ", Printable(column.name), " = ", value,
                                                     ": LAS holds finite coordinates only. PLY, PCD and CSV hold "
                                                     "others"));
    }
    extent.low = std::min(extent.low, value);
    extent.high = std::max(extent.high, value);
  }
  if (!std::isfinite(extent.high - extent.low)) {
    return absl::InvalidArgumentError(absl::StrCat("column ", Printable(column.name), " reaches from ", extent.low,
                                                   " to ", extent.high, ": its extent is outside the range of double"));
  }
  return extent;
}

// Whether every value comes back from the lattice in its own type.
bool HoldsAll(const LasAxis& axis, const Column& column) {
  return std::visit(
      [&axis](const auto& values) {
        using Value = typename std::decay_t<decltype(values)>::value_type;
        return std::all_of(values.begin(), values.end(), [&axis](Value value) {
          const double step = RawStep(axis, static_cast<double>(value));
          return IsStep(step) && static_cast<Value>(axis.At(static_cast<int32_t>(step))) == value;
        });
      },
      column.values);
}

bool Reaches(const LasAxis& axis, const Extent& extent) {
  return IsStep(RawStep(axis, extent.low)) && IsStep(RawStep(axis, extent.high));
}

// A lattice of that scale from whose origin every step of the extent has a number of 32 bits: the origin is 0 if that
// will do, or a whole number. None if there is no such number.
std::optional<LasAxis> AxisOf(double scale, const Extent& extent) {
  const double middle = extent.low + (extent.high - extent.low) / 2;
  for (const double offset : {0.0, std::nearbyint(middle)}) {
    const LasAxis axis{scale, offset};
    if (Reaches(axis, extent)) return axis;
  }
  return std::nullopt;
}

// As fine as 32 bits allow, but for a sixteenth that rounding may take.
LasAxis FinestAxis(const Extent& extent) {
  const double range = extent.high - extent.low;
  if (range == 0.0) return {.scale = 0.001, .offset = extent.low};
  constexpr double kSteps = 4'026'531'840.0;  // 2^32 * 15 / 16
  const double scale = std::max(range / kSteps, std::numeric_limits<double>::min());
  return AxisOf(scale, extent).value_or(LasAxis{scale, extent.low + range / 2});
}

}  // namespace

absl::StatusOr<LasAxis> ChooseAxis(const Column& coordinates, const std::optional<LasAxis>& preferred) {
  const absl::StatusOr<Extent> extent = ExtentOf(coordinates);
  if (!extent.ok()) return extent.status();
  if (preferred.has_value() && HoldsAll(*preferred, coordinates)) return *preferred;
  // Divisions, so that each is the double nearest to the power of ten.
  for (const double steps : {1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12}) {
    const std::optional<LasAxis> axis = AxisOf(1.0 / steps, *extent);
    if (!axis.has_value()) break;
    if (HoldsAll(*axis, coordinates)) return *axis;
  }
  return FinestAxis(*extent);
}

int32_t StepOf(const LasAxis& axis, double value) {
  return static_cast<int32_t>(std::clamp(RawStep(axis, value), kLeastStep, kMostStep));
}

}  // namespace curv
