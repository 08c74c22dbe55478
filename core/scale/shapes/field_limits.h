// When normals are those of no surface.
#pragma once

namespace curvd {

// The mean of unit normals, or what is fitted to them at a point, is no normal if it is shorter: they nearly cancel
// out.
inline constexpr double kLeastLengthOfMeanNormal = 0.1;
// Nor is it one if its cosine to the normal of the frame that it was fitted in is less: it contradicts the frame.
inline constexpr double kLeastCosineToFrame = 0.2;

}  // namespace curvd
