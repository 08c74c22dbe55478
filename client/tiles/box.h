// Axis-parallel boxes, and how far things are from them.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace curv {

using Position = std::array<double, 3>;

// Closed; holds nothing until something is added. All distances are in the unit of the positions.
struct Box {
  Position low{kInfinity, kInfinity, kInfinity};
  Position high{-kInfinity, -kInfinity, -kInfinity};

  bool empty() const { return low[0] > high[0]; }
  double Extent(size_t axis) const { return empty() ? 0.0 : high[axis] - low[axis]; }
  // The axis of the longest extent, the first of them.
  size_t LongestAxis() const {
    size_t longest = 0;
    for (size_t axis = 1; axis < 3; ++axis) {
      if (Extent(axis) > Extent(longest)) longest = axis;
    }
    return longest;
  }

  void Add(const Position& p) {
    for (size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], p[axis]);
      high[axis] = std::max(high[axis], p[axis]);
    }
  }
  void Add(const Box& other) {
    if (other.empty()) return;
    Add(other.low);
    Add(other.high);
  }

  // To the nearest place of the box: 0 within, infinite if it is empty.
  double DistanceTo(const Position& p) const { return DistanceTo(Box{p, p}); }
  double DistanceTo(const Box& other) const {
    double sum = 0.0;
    for (size_t axis = 0; axis < 3; ++axis) {
      const double gap = std::max({low[axis] - other.high[axis], other.low[axis] - high[axis], 0.0});
      sum += gap * gap;
    }
    return std::sqrt(sum);
  }
  // To the farthest place. REQUIRES: not empty.
  double FarDistanceTo(const Position& p) const {
    double sum = 0.0;
    for (size_t axis = 0; axis < 3; ++axis) {
      const double gap = std::max(p[axis] - low[axis], high[axis] - p[axis]);
      sum += gap * gap;
    }
    return std::sqrt(sum);
  }
  // From a place within to the nearest face; 0 or less outside.
  double DepthOf(const Position& p) const {
    double depth = kInfinity;
    for (size_t axis = 0; axis < 3; ++axis) depth = std::min({depth, p[axis] - low[axis], high[axis] - p[axis]});
    return depth;
  }

 private:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
};

}  // namespace curv
