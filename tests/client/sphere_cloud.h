// The cloud that the C++ client sends in tests.
#pragma once

#include <cstddef>
#include <vector>

#include "client/curvature_client.h"
#include "client/surfaces/surface.h"

namespace curv {

struct SphereCloud {
  std::vector<float> points;  // of the unit sphere: their own normals
  CloudView view() const { return {points, points}; }
};

inline SphereCloud Sphere(size_t count) {
  SphereCloud cloud;
  const std::vector<Vec3> positions = *SampleEvenly(**MakeSurface("sphere"), count, 0);
  for (const Vec3& p : positions) {
    for (int axis = 0; axis < 3; ++axis) cloud.points.push_back(static_cast<float>(p[axis]));
  }
  return cloud;
}

}  // namespace curv
