// Clouds whose normals are right, also where they are opposed, and what makes them wrong.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "tests/core/test_clouds.h"

namespace curvd::testing {

// Points at random on a sphere around the origin, outward normals.
TestPoints RandomSphere(size_t points, double radius, uint64_t seed);
// On a torus around the z axis with radii 2 and 1, outward normals.
TestPoints RandomTorus(size_t points, uint64_t seed);

// The two large faces of a plate of 2 x 2, normals outward, without its narrow sides; `thickness` in spacings: the
// distance at which an even sample of so many points would lie. A negative one is a gap: its faces look at each other.
TestPoints Plate(size_t points, double thickness, uint64_t seed);
// Two spheres around the origin that enclose a shell of this thickness, in spacings; the larger has radius 1.
TestPoints Shell(size_t points, double thickness, uint64_t seed);
// Two faces of length 1 that meet at this angle along an edge of length 4, normals outward.
TestPoints Wedge(size_t points, double degrees, uint64_t seed);
// A sphere that is flattened so that its thickness is this many spacings in the middle, and 0 at its rim.
TestPoints Lens(size_t points, double thickness, uint64_t seed);

// Adds Gaussian noise of these standard deviations to each coordinate of positions and normals, and normalizes these.
void AddNoise(double position, double normal, uint64_t seed, TestPoints& points);

// Whether each normal is wrong.
using Flips = std::vector<char>;
// Negates each normal with this probability.
Flips FlipAtRandom(double share, uint64_t seed, TestPoints& points);
// Negates the normals of points at positions that `where` tells.
Flips FlipWhere(const std::function<bool(const std::array<float, 3>&)>& where, TestPoints& points);

// The OK points of a result that have, within their radius, points of one sheet with right and with wrong normals.
// `sheets`: a number for each point; where it is empty, there is one sheet.
std::vector<size_t> OkAcrossSeams(const TestPoints& points, const Flips& flips, const CurvatureField& field,
                                  const std::vector<char>& sheets = {});

}  // namespace curvd::testing
