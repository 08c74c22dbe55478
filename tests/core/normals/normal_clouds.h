// Clouds whose normals are known, and what became of them.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/job/normals_job.h"
#include "core/normals/normal_fit.h"
#include "core/normals/normal_options.h"
#include "core/normals/normals.h"
#include "tests/core/seam_clouds.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {

// A torus around the z axis with radii 6 and 2, evenly spread at random.
TestPoints Torus(size_t points, uint64_t seed);
// A box of 2 x 2 x thickness, its narrow sides included, of about `points` points on a grid that is shaken by a third
// of its spacing.
TestPoints ClosedPlate(size_t points, double thickness, uint64_t seed);
// The saddle z = (x^2 - y^2) / 2 over a square of side 2, as a scanner leaves it: on lines along x, each `gap` times as
// far from the next one as its points lie from each other. These are off along the normal by Gaussians of `noise` times
// that.
TestPoints ScannedSaddle(size_t points, double gap, double noise, uint64_t seed);
// An ellipsoid with axes 1, 0.7 and 0.4 on 30 lines at even heights, of 489 points each: around the poles the lines are
// the farthest from each other. Points are off along the normal by Gaussians of `sigma`.
TestPoints ScannedEllipsoid(double sigma, uint64_t seed);
// Whether two lines of unit vectors are 15 degrees apart and more.
bool IsFarOff(const std::array<float, 3>& a, const std::array<float, 3>& b);
// Moves each coordinate by a Gaussian of standard deviation sigma.
void AddNoise(double sigma, uint64_t seed, TestPoints& points);
void Shift(double x, double y, double z, TestPoints& points);
void Append(const TestPoints& more, TestPoints& points);

// The points without their normals.
Cloud BareCloud(const TestPoints& points);

// Makes normals with `threads` threads; fails the test on error.
NormalResult MustMakeNormals(Cloud cloud, const NormalOptions& options, int threads = 2);

// Estimates, by what the noise asks for.
NormalOptions Estimated();
// Estimates by `method` of `count` neighbors.
NormalOptions EstimateBy(NormalMethod method, uint32_t count);

// What a fit makes of an index, by place in the tree order.
struct PlacedNormals {
  std::vector<std::array<float, 3>> normals;
  std::vector<PointStatus> statuses;
  std::vector<float> residuals;
  std::vector<float> variance_ratios;
};
// Fits all points of the index, and writes their normals there. Runs end where they have taken `most_work` steps, and
// others go on. Fails the test on error.
PlacedNormals MakeByPlace(SpatialIndex& index, const NormalFit& fit, uint64_t most_work = WorkerScratch::kMostRunWork);

// Makes normals of halves, likewise. REQUIRES: the index has normals.
void MakeHalfNormals(SpatialIndex& index, const NormalFit& fit, uint64_t most_work = WorkerScratch::kMostRunWork);

// How many points have their normal in place of one of a half. REQUIRES: the index has half normals.
size_t CountKeptByHalves(const SpatialIndex& index, const PlacedNormals& made);

// Expects the same normals, and the same normals of halves, whether each run ends when it likes or after each step.
void ExpectSameNormalsInParts(const TestPoints& points, const NormalFit& fit);

// Makes normals anew, in the place of half normals, likewise. REQUIRES: the index has normals.
void RefitNormals(SpatialIndex& index, const NormalFit& fit, uint64_t most_work = WorkerScratch::kMostRunWork);

// Mean angle in degrees between the lines of the normals made and those of `points`, over the points that have one.
double MeanAngle(const NormalField& normals, const TestPoints& points);
// The share of the points with a normal whose normal points to the other side than that of `points`.
double FlippedShare(const NormalField& normals, const TestPoints& points);
// Whether all bytes that are values agree.
bool SameBytes(const NormalField& a, const NormalField& b);

}  // namespace curvd::testing
