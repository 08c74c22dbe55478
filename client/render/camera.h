// Chooses where a picture is taken from.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "client/surfaces/vec3.h"

namespace curv {

// An orthographic view: unit vectors to the right and upward in the picture, and toward the viewer.
struct View {
  Vec3 right;
  Vec3 up;
  Vec3 toward;

  // Returns the coordinates of a position or direction along right, up and toward.
  Vec3 Turn(const Vec3& v) const { return {Dot(v, right), Dot(v, up), Dot(v, toward)}; }
};

// The names of views, for help texts.
inline constexpr char kViewNames[] = "three-quarter, front, back, left, right, top, bottom or AZIMUTH:ELEVATION";

// Returns the view of that name, or of "AZIMUTH:ELEVATION" in degrees. The azimuth goes counterclockwise from the front
// as seen from the top, the elevation from the horizon upward. `up_axis` is 'y' or 'z'; the front is then seen from +z
// or -y. INVALID_ARGUMENT for anything else.
absl::StatusOr<View> MakeView(std::string_view name, char up_axis);

}  // namespace curv
