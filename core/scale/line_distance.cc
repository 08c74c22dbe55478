#include "core/scale/line_distance.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/scale/pilot/neighbor_copies.h"

namespace curvd {
namespace {

// Points lie on a line if the nearest ones spread across it by at most this part of what they do along it, in standard
// deviations: eight of them, or six, or four if each of these does, since four are easily in a row by chance.
constexpr double kAcrossPerAlong = 0.26;
constexpr std::array<size_t, 3> kOnLine = {8, 6, 4};
// Beyond them, neighbors are off the line that are so many standard deviations away from it, and as far as that part of
// their distance. The first of these is so many times as far away as the fourth neighbor.
constexpr double kDeviationsOffLine = 4.0, kLeastGap = 1.25;
// Small neighborhoods see detail if what they show otherwise along lines is more than this part of the difference of
// the mean curvature.
constexpr double kMostAlongLines = 0.5;
// What chance determines shows it: those neighborhoods differ from larger ones by more than so many times what the
// larger ones differ among each other.
constexpr double kMostOverDetermined = 4.0;
// Of the points on lines, so many may have neighborhoods that cross too few: where distances of lines differ, what
// would be determined at all of them is too large for most.
constexpr double kMostUndetermined = 0.25;

// A neighbor in the tangent plane.
struct Place {
  double x, y;
  double squared;  // of its distance from the point, in space
};

struct Axis {
  double x, y;
  double deviation;  // standard, of the points across it

  bool IsOff(const Place& place) const {
    const double across = std::abs(place.y * x - place.x * y);
    return across > kAcrossPerAlong * std::sqrt(place.squared) && across > kDeviationsOffLine * deviation;
  }
};

// The line through the point along which its nearest neighbors lie, if they do.
std::optional<Axis> AxisOf(std::span<const Place> nearest) {
  double xx = 0.0, xy = 0.0, yy = 0.0;
  for (const Place& place : nearest) {
    xx += place.x * place.x;
    xy += place.x * place.y;
    yy += place.y * place.y;
  }
  const double half = 0.5 * (xx - yy), root = std::hypot(half, xy), middle = 0.5 * (xx + yy);
  const double along = middle + root, across = std::max(middle - root, 0.0);
  if (!(across <= kAcrossPerAlong * kAcrossPerAlong * along)) return std::nullopt;
  const double angle = 0.5 * std::atan2(xy, half);
  return Axis{std::cos(angle), std::sin(angle), std::sqrt(across / static_cast<double>(nearest.size()))};
}

// The axis of as many of the nearest neighbors as lie along one.
std::optional<Axis> LongestAxisOf(std::span<const Place> nearest) {
  for (const size_t count : kOnLine) {
    const std::span<const Place> first = nearest.first(std::min(count, nearest.size()));
    std::optional<Axis> axis = AxisOf(first);
    if (!axis.has_value()) continue;
    if (count > kOnLine.back()) return axis;
    axis->deviation = 0.0;
    if (std::none_of(first.begin(), first.end(), [&](const Place& place) { return axis->IsOff(place); })) return axis;
  }
  return std::nullopt;
}

// The least radius of a neighborhood, in distances of lines, that tells the polynomials of a method. The outermost
// lines count for little.
double LeastRadius(size_t method) {
  constexpr double kPerDegree = 0.5, kBeyond = 0.5;
  return kPerDegree * std::max(kScaleMethods[method].degree, 1U) + kBeyond;
}

bool IsDetermined(const PilotPoint& point, size_t method, size_t rung) {
  return point.radius[rung] >= LeastRadius(method) * point.line_distance;
}

// What one rung of a method shows.
struct Bends {
  double mean, along_line;
};

Bends BendsAt(const PilotPoint& point, size_t method, size_t rung) {
  const auto of = [&](const PilotPoint::Estimates& estimates) {
    return double{estimates[method][rung][PilotPoint::kAll]};
  };
  const double mean = of(point.mean);
  return {mean, mean + point.line[0] * of(point.difference) + point.line[1] * of(point.twist)};
}

// By how much neighborhoods differ, by one method.
struct Differences {
  Bends of_smallest;          // the smallest one, from the first that is determined
  double mean_of_determined;  // H of the first that is determined, from that of the next
};

std::optional<Differences> DifferencesAt(const PilotPoint& point, size_t method) {
  std::optional<Bends> smallest, first_determined;
  for (size_t rung = 0; rung < kRungCount; ++rung) {
    const Bends bends = BendsAt(point, method, rung);
    if (!std::isfinite(bends.mean + bends.along_line)) continue;
    if (first_determined.has_value()) {
      return Differences{{std::abs(first_determined->mean - smallest->mean),
                          std::abs(first_determined->along_line - smallest->along_line)},
                         std::abs(bends.mean - first_determined->mean)};
    }
    const bool is_determined = IsDetermined(point, method, rung);
    if (!smallest.has_value()) {
      if (is_determined) return std::nullopt;
      smallest = bends;
    } else if (is_determined) {
      first_determined = bends;
    }
  }
  return std::nullopt;
}

// Their sums over the points.
Differences DifferencesOf(std::span<const PilotPoint> points, size_t method) {
  Differences sum{{0.0, 0.0}, 0.0};
  for (const PilotPoint& point : points) {
    if (!(point.line_distance > 0.0f)) continue;
    const std::optional<Differences> found = DifferencesAt(point, method);
    if (!found.has_value()) continue;
    sum.of_smallest.mean += found->of_smallest.mean;
    sum.of_smallest.along_line += found->of_smallest.along_line;
    sum.mean_of_determined += found->mean_of_determined;
  }
  return sum;
}

bool HasDetermined(const PilotPoint& point, const ScaleBounds& bounds) {
  for (size_t method = 0; method < kMethodCount; ++method) {
    for (size_t rung = 0; rung < kRungCount && bounds.methods[method]; ++rung) {
      const bool is_allowed = kScaleRungs[rung] >= bounds.least_count && kScaleRungs[rung] <= bounds.most_count &&
                              point.radius[rung] <= bounds.most_radius;
      const bool is_known = std::isfinite(point.mean[method][rung][PilotPoint::kAll]);
      if (is_allowed && is_known && IsDetermined(point, method, rung)) return true;
    }
  }
  return false;
}

void Drop(size_t method, size_t rung, PilotPoint& point) {
  for (PilotPoint::Estimates* const estimates : {&point.mean, &point.difference, &point.twist}) {
    (*estimates)[method][rung].fill(PilotPoint::kNone);
  }
  // What is left of the heights, of which noise across the lines explains some.
  if (method == kQuarticMethod) point.residual[rung] = PilotPoint::kNone;
}

}  // namespace

PointLine LineOf(const PilotScratch& s, const std::array<double, 3>& x_axis, const std::array<double, 3>& y_axis) {
  const NeighborArrays& n = s.neighbors;
  const auto along = [&](const std::array<double, 3>& to, uint32_t j) {
    return to[0] * n.dx[j] + to[1] * n.dy[j] + to[2] * n.dz[j];
  };
  std::vector<Place> nearest;
  std::optional<Axis> axis;
  // Those of the nearest that are not needed for the axis, and all others.
  const auto ends = [&](const Place& place) { return axis->IsOff(place); };
  const auto line_before = [&](const Place& place) {
    PointLine line;
    if (place.squared <= kLeastGap * kLeastGap * nearest[kOnLine.back() - 1].squared) return line;
    line.distance = std::sqrt(place.squared);
    for (size_t k = 0; k < 3; ++k) line.direction[k] = axis->x * x_axis[k] + axis->y * y_axis[k];
    return line;
  };
  for (const uint32_t j : s.order) {
    if (!(s.squared[j] > 0.0f) || IsCopy(s.ids[j])) continue;
    const Place place = {along(x_axis, j), along(y_axis, j), s.squared[j]};
    if (axis.has_value()) {
      if (ends(place)) return line_before(place);
      continue;
    }
    nearest.push_back(place);
    if (nearest.size() < kOnLine.front()) continue;
    axis = LongestAxisOf(nearest);
    if (!axis.has_value()) return {};
    const auto end = std::find_if(nearest.begin(), nearest.end(), ends);
    if (end != nearest.end()) return line_before(*end);
  }
  return {};
}

void DropUndeterminedAcrossLines(const ScaleBounds& bounds, std::span<PilotPoint> points) {
  size_t on_lines = 0, with_determined = 0;
  for (const PilotPoint& point : points) {
    if (!(point.line_distance > 0.0f)) continue;
    ++on_lines;
    with_determined += HasDetermined(point, bounds) ? 1 : 0;
  }
  if (2 * on_lines < points.size() || 2 * with_determined < on_lines) return;
  const Bends difference = DifferencesOf(points, kRegressionMethod).of_smallest;
  if (!(difference.mean > 0.0) || difference.along_line > kMostAlongLines * difference.mean) return;
  for (size_t method = 0; method < kMethodCount; ++method) {
    const auto& [of_smallest, of_determined] = DifferencesOf(points, method);
    if (of_determined > 0.0 && of_smallest.mean <= kMostOverDetermined * of_determined) continue;
    for (size_t rung = 0; rung < kRungCount; ++rung) {
      const auto undetermined = std::count_if(points.begin(), points.end(), [&](const PilotPoint& point) {
        return point.line_distance > 0.0f && !IsDetermined(point, method, rung);
      });
      if (static_cast<double>(undetermined) <= kMostUndetermined * static_cast<double>(on_lines)) continue;
      for (PilotPoint& point : points) {
        if (point.line_distance > 0.0f) Drop(method, rung, point);
      }
    }
  }
}

}  // namespace curvd
