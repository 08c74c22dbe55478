// The principal directions of a symmetric tensor in a tangent plane.
#pragma once

#include <array>
#include <cmath>

#include "Eigen/Geometry"

namespace curvd {

// In single precision, as results have them.
struct PrincipalDirections {
  std::array<float, 3> d1, d2;  // d1 x d2 is the normal
};

// `half` is half of what the tensor's entry along u exceeds that along v by, and `mixed` the entry of both. d2 belongs
// to the larger eigenvalue; where both eigenvalues are equal, d2 is u. REQUIRES: u, v and normal are orthonormal, and u
// x v = normal.
inline PrincipalDirections DirectionsOf(double half, double mixed, const Eigen::Vector3d& u, const Eigen::Vector3d& v,
                                        const Eigen::Vector3d& normal) {
  const auto to_floats = [](const Eigen::Vector3d& w) {
    return std::array{static_cast<float>(w.x()), static_cast<float>(w.y()), static_cast<float>(w.z())};
  };
  // The direction of the larger eigenvalue of [[half, mixed], [mixed, -half]].
  const double angle = 0.5 * std::atan2(mixed, half);
  const Eigen::Vector3d d2 = std::cos(angle) * u + std::sin(angle) * v;
  return {to_floats(d2.cross(normal)), to_floats(d2)};
}

}  // namespace curvd
