#include "client/render/framing.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <utility>

#include "client/render/local_spacing.h"

namespace curv {
namespace {

// Discs as wide as the way to the sixth neighbor leave no holes in a cloud that is spread at random.
constexpr int kSpacingRank = 6;
// A lonely point is not drawn larger than this many times the usual.
constexpr double kLargestDisc = 4.0;
constexpr double kLargestShare = 1.0 / 6.0;
// How many discs of median size there is room for, side by side, in the smallest frame.
constexpr double kFewestDiscs = 4.0;

struct Box {
  Vec3 low;
  Vec3 high;

  void Add(const Vec3& p, const Vec3& reach) {
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], p[axis] - reach[axis]);
      high[axis] = std::max(high[axis], p[axis] + reach[axis]);
    }
  }
  double LargestExtent() const { return std::max({high.x - low.x, high.y - low.y, high.z - low.z}); }
};

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// How far a disc reaches along each axis from its center.
Vec3 Reach(const Disc& disc) {
  const auto along = [&](double n) { return disc.radius * std::sqrt(std::max(0.0, 1.0 - n * n)); };
  return {along(disc.normal.x), along(disc.normal.y), along(disc.normal.z)};
}

}  // namespace

std::vector<double> DiscRadii(const std::vector<Vec3>& positions) {
  Box box{positions.front(), positions.front()};
  for (const Vec3& p : positions) box.Add(p, {});
  const double extent = box.LargestExtent();
  if (extent == 0.0) return std::vector<double>(positions.size(), 1.0);
  std::vector<double> radii = LocalSpacing(positions, kSpacingRank);
  std::vector<double> apart;
  std::copy_if(radii.begin(), radii.end(), std::back_inserter(apart), [](double spacing) { return spacing > 0.0; });
  const double usual = std::min(apart.empty() ? extent : Median(std::move(apart)), kLargestShare * extent);
  for (double& radius : radii) {
    radius = radius > 0.0 ? std::min({radius, kLargestDisc * usual, kLargestShare * extent}) : usual;
  }
  return radii;
}

Framing FitFrame(const std::vector<Disc>& discs, double width, double height, double margin) {
  Box box{discs.front().center, discs.front().center};
  std::vector<double> radii;
  for (const Disc& disc : discs) {
    box.Add(disc.center, Reach(disc));
    radii.push_back(disc.radius);
  }
  const double least = kFewestDiscs * 2.0 * Median(std::move(radii));
  const Vec3 extent = box.high - box.low;
  return {.scale = std::min((width - 2.0 * margin) / std::max(least, extent.x),
                            (height - 2.0 * margin) / std::max(least, extent.y)),
          .center = 0.5 * (box.low + box.high)};
}

}  // namespace curv
