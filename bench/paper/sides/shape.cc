#include "bench/paper/sides/shape.h"

#include <cmath>

#include "client/surfaces/vec3.h"

namespace curvd::bench {

using curv::Vec3;

void Tilt(double angle, Samples& samples) {
  const Vec3 axis = (1.0 / std::sqrt(1.0 + 4.0 + 9.0)) * Vec3{1, 2, 3};
  const double c = std::cos(angle), s = std::sin(angle);
  for (auto* vectors : {&samples.positions, &samples.normals}) {
    for (Vec3& v : *vectors) v = c * v + s * curv::Cross(axis, v) + ((1.0 - c) * curv::Dot(axis, v)) * axis;
  }
}

}  // namespace curvd::bench
