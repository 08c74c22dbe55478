#include "core/scale/line_distance.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/scale/pilot/neighbor_copies.h"

namespace curvd {
namespace {

// A neighbor lies on the line through the point and its nearest one if the sine of the angle between them is at most
// this. Points lie on lines if so many of the nearest do, and the first that does not is so many times as far away as
// the last of these.
constexpr float kSineOnLine = 0.26f;
constexpr size_t kLeastOnLine = 4;
constexpr float kLeastGap = 1.25f;
// Small neighborhoods see detail if what they show otherwise along lines is more than this part of the difference of
// the mean curvature.
constexpr double kMostAlongLines = 0.5;

using Offset = std::array<float, 3>;

float SquaredLength(const Offset& v) { return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]; }

Offset Cross(const Offset& a, const Offset& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// The least radius of a neighborhood, in distances of lines, that tells the polynomials of a method. The outermost
// lines count for little.
double LeastRadius(size_t method) {
  constexpr double kPerDegree = 0.5, kBeyond = 0.5;
  return kPerDegree * std::max(kScaleMethods[method].degree, 1U) + kBeyond;
}

bool IsTold(const PilotPoint& point, size_t method, size_t rung) {
  return point.radius[rung] >= LeastRadius(method) * point.line_distance;
}

// What one rung of the cubic regression shows.
struct Bends {
  double mean, along_line;
};

Bends BendsAt(const PilotPoint& point, size_t rung) {
  const auto of = [&](const PilotPoint::Estimates& estimates) {
    return double{estimates[kRegressionMethod][rung][PilotPoint::kAll]};
  };
  const double mean = of(point.mean);
  return {mean, mean + point.line[0] * of(point.difference) + point.line[1] * of(point.twist)};
}

// By how much the smallest neighborhood differs from the first that is told.
std::optional<Bends> DifferenceOfSmallest(const PilotPoint& point) {
  std::optional<Bends> smallest;
  for (size_t rung = 0; rung < kRungCount; ++rung) {
    const Bends bends = BendsAt(point, rung);
    if (!std::isfinite(bends.mean + bends.along_line)) continue;
    const bool is_told = IsTold(point, kRegressionMethod, rung);
    if (!smallest.has_value()) {
      if (is_told) return std::nullopt;
      smallest = bends;
    } else if (is_told) {
      return Bends{std::abs(bends.mean - smallest->mean), std::abs(bends.along_line - smallest->along_line)};
    }
  }
  return std::nullopt;
}

bool HasTold(const PilotPoint& point, const ScaleBounds& bounds) {
  for (size_t method = 0; method < kMethodCount; ++method) {
    for (size_t rung = 0; rung < kRungCount && bounds.methods[method]; ++rung) {
      const bool is_allowed = kScaleRungs[rung] >= bounds.least_count && kScaleRungs[rung] <= bounds.most_count &&
                              point.radius[rung] <= bounds.most_radius;
      const bool is_known = std::isfinite(point.mean[method][rung][PilotPoint::kAll]);
      if (is_allowed && is_known && IsTold(point, method, rung)) return true;
    }
  }
  return false;
}

void DropAt(PilotPoint& point) {
  for (size_t method = 0; method < kMethodCount; ++method) {
    for (size_t rung = 0; rung < kRungCount && !IsTold(point, method, rung); ++rung) {
      for (PilotPoint::Estimates* const estimates : {&point.mean, &point.difference, &point.twist}) {
        (*estimates)[method][rung].fill(PilotPoint::kNone);
      }
    }
  }
}

}  // namespace

PointLine LineOf(const PilotScratch& s) {
  const NeighborArrays& n = s.neighbors;
  size_t on_line = 0;
  Offset nearest{};
  float last_squared = 0.0f;  // of those that must lie on the line
  for (const uint32_t j : s.order) {
    if (!(s.squared[j] > 0.0f) || IsCopy(s.ids[j])) continue;
    const Offset offset = {n.dx[j], n.dy[j], n.dz[j]};
    if (on_line == 0) nearest = offset;
    const float squared_sine = SquaredLength(Cross(nearest, offset)) / (SquaredLength(nearest) * s.squared[j]);
    if (squared_sine > kSineOnLine * kSineOnLine) {
      if (on_line < kLeastOnLine || s.squared[j] <= kLeastGap * kLeastGap * last_squared) return {};
      const double length = std::sqrt(double{SquaredLength(nearest)});
      return {std::sqrt(double{s.squared[j]}), {nearest[0] / length, nearest[1] / length, nearest[2] / length}};
    }
    if (++on_line == kLeastOnLine) last_squared = s.squared[j];
  }
  return {};
}

void DropUntoldAcrossLines(const ScaleBounds& bounds, std::span<PilotPoint> points) {
  size_t on_lines = 0, with_told = 0;
  Bends difference{0.0, 0.0};
  for (const PilotPoint& point : points) {
    if (!(point.line_distance > 0.0f)) continue;
    ++on_lines;
    with_told += HasTold(point, bounds) ? 1 : 0;
    const std::optional<Bends> found = DifferenceOfSmallest(point);
    if (!found.has_value()) continue;
    difference.mean += found->mean;
    difference.along_line += found->along_line;
  }
  if (2 * on_lines < points.size() || 2 * with_told < on_lines || !(difference.mean > 0.0)) return;
  if (difference.along_line > kMostAlongLines * difference.mean) return;
  for (PilotPoint& point : points) {
    if (point.line_distance > 0.0f) DropAt(point);
  }
}

}  // namespace curvd
