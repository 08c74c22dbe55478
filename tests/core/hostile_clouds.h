// Clouds that are made to cost too much: equal points, far outliers, lattices, spheres around a center.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace curvd::testing {

struct HostileCloud {
  std::string_view name;
  // Makes the cloud, always the same for the same number of points: calls for each point and its unit normal go into
  // the two arrays, in the order of input.
  void (*make)(size_t points, std::vector<std::array<float, 3>>& positions, std::vector<std::array<float, 3>>& normals);
};

// All of them, each of any number of points.
std::span<const HostileCloud> HostileClouds();

// The cloud's name with '_' for what may not stand in the name of a test.
std::string IdentifierOf(const HostileCloud& cloud);

}  // namespace curvd::testing
