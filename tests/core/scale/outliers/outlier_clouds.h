// A torus with points that lie off it, and what an estimate makes of them.
#pragma once

#include <cstddef>

#include "core/cloud/cloud.h"
#include "core/job/estimation_job.h"
#include "tests/core/test_clouds.h"
#include "tests/core/true_clouds.h"

namespace curvd::testing {

// The points of a torus of radii 3 and 1, and their spacing.
inline constexpr size_t kTorusPoints = 10'000;
inline constexpr double kTorusSpacing = 0.109;

// The outliers follow the points of the torus.
struct TorusWithOutliers {
  TruePoints torus;
  TestPoints& points() { return torus.points; }
  const TestPoints& points() const { return torus.points; }

  bool IsOutlier(size_t i) const { return i >= kTorusPoints; }
  // The same with the outliers as invalid points.
  Cloud WithInvalidOnes() const;
};

// Without outliers; the noise of the positions in spacings.
TorusWithOutliers TorusWithoutOutliers(double noise);
// With outliers at 2 to 10 spacings from the surface, with about its normal.
TorusWithOutliers WithOutliersNearby(double noise, size_t outliers);
// With outliers anywhere in the box of the torus, with any normal.
TorusWithOutliers WithOutliersAnywhere(double noise, size_t outliers);

// What became of the points of the surface, and of the outliers.
struct OutlierOutcome {
  size_t found = 0, mistaken = 0, without_result = 0;
  double error = 0.0;  // mean |H error| of the points of the surface that have a result
};
OutlierOutcome OutcomeOf(const TorusWithOutliers& cloud, const EstimationResult& result);

// How many points the estimate calls outliers.
size_t CountOutliers(const EstimationResult& result);

}  // namespace curvd::testing
