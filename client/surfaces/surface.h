// Analytic surfaces with exact curvature: what estimates are measured against.
//
// Conventions are those of the service: normals point outward (up for the saddle and the plane), a sphere of radius r
// has mean curvature +1 / r, k1 <= k2, and d1 x d2 is the normal.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "client/surfaces/vec3.h"

namespace curv {

// Value, gradient and Hessian of a function f of the position; the surface is f = 0, and f > 0 outside.
struct ImplicitJet {
  double value = 0.0;
  Vec3 gradient;
  Vec3 hessian_diagonal;      // f_xx f_yy f_zz
  Vec3 hessian_off_diagonal;  // f_yz f_xz f_xy
};

// Exact differential quantities at a position on a surface.
struct SurfaceGeometry {
  Vec3 normal;      // unit, outward
  double mean;      // (k1 + k2) / 2
  double gaussian;  // k1 * k2
  double k1;        // <= k2
  double k2;
  Vec3 d1;  // unit direction of k1; any tangent direction where k1 = k2
  Vec3 d2;  // unit direction of k2; d1 x d2 = normal
};

// An axis-aligned box, bounds included.
struct Box {
  Vec3 low;
  Vec3 high;
};

// Immutable and thread-safe.
class Surface {
 public:
  virtual ~Surface() = default;

  virtual std::string_view name() const = 0;
  // Contains the surface. An open surface is f = 0 cut off at those faces of the box that it reaches (is_open).
  virtual Box bounds() const = 0;
  // Whether the surface is cut off at the two faces of bounds() across `axis` (0, 1, 2). DEFAULT: closed.
  virtual bool is_open(int /*axis*/) const { return false; }
  // Value and gradient of f alone.
  virtual double Evaluate(const Vec3& position, Vec3& gradient) const = 0;
  virtual ImplicitJet Jet(const Vec3& position) const = 0;

  // Exact quantities at `position`, which should be on the surface (Project); elsewhere those of the level set through
  // it. REQUIRES: the gradient does not vanish there.
  SurfaceGeometry At(const Vec3& position) const;

  // A position on f = 0 near `position`, by Newton steps along the gradient: |f| <= 1e-14 relative to the size of the
  // bounds where it starts within half the smallest radius of curvature. It is close to the nearest position, not equal
  // to it. Open surfaces: the result is not cut off.
  Vec3 Project(Vec3 position) const;
  // The same, with the result within the bounds.
  Vec3 ProjectWithin(const Vec3& position) const;

  // Lower bound of the distance from `position`, within the bounds, to where the surface is cut off; infinity for
  // closed surfaces.
  double DistanceToBorder(const Vec3& position) const;
};

// Names that MakeSurface knows, in the order of its documentation.
std::vector<std::string_view> SurfaceNames();

// Returns the surface of that name, in fixed proportions:
// - sphere: radius 1
// - torus: distance of the circle 6, radius of the tube 2, around the z axis
// - cylinder: radius 1 around the z axis, |z| <= 2, without caps
// - saddle: z = (x^2 - y^2) / 2 over |x|, |y| <= 1
// - goursat: 8 + 2 (x^2 + y^2 + z^2) - 0.03 (x^4 + y^4 + z^4) = 0, a rounded cube about 19 wide
// - ellipsoid: semi-axes 3, 2, 1
// - plane: z = 0 over |x|, |y| <= 1
// INVALID_ARGUMENT, listing the names, for any other.
absl::StatusOr<std::unique_ptr<Surface>> MakeSurface(std::string_view name);

// Most points that SampleEvenly makes.
inline constexpr size_t kMaxSamplePoints = 100'000'000;

// Returns `points` positions on the surface, evenly spread (the distance to the nearest other point varies by about a
// tenth of its mean) and in random order. The same seed gives the same positions.
// INVALID_ARGUMENT unless 1 <= points <= kMaxSamplePoints.
absl::StatusOr<std::vector<Vec3>> SampleEvenly(const Surface& surface, size_t points, uint64_t seed);

}  // namespace curv
