#include "tests/core/scale/outliers/outlier_clouds.h"

#include <cmath>
#include <limits>
#include <random>

#include "tests/core/normals/normal_clouds.h"

namespace curvd::testing {

Cloud TorusWithOutliers::WithInvalidOnes() const {
  TestPoints without = points();
  for (size_t i = kTorusPoints; i < without.size(); ++i) {
    without.positions[i][0] = std::numeric_limits<float>::quiet_NaN();
  }
  return without.ToCloud();
}

TorusWithOutliers TorusWithoutOutliers(double noise) {
  TorusWithOutliers cloud{TrueTorus(kTorusPoints, 5)};
  AddNoise(noise * kTorusSpacing, 7, cloud.points());
  return cloud;
}

TorusWithOutliers WithOutliersNearby(double noise, size_t outliers) {
  TorusWithOutliers cloud = TorusWithoutOutliers(noise);
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> spacings(2.0, 10.0);
  for (size_t j = 0; j < outliers; ++j) {
    const size_t i = random() % kTorusPoints;
    const auto p = cloud.points().positions[i], n = cloud.points().normals[i];
    const double off = (j % 2 == 0 ? 1.0 : -1.0) * spacings(random) * kTorusSpacing;
    cloud.points().Add(p[0] + off * n[0], p[1] + off * n[1], p[2] + off * n[2], n[0], n[1], n[2]);
  }
  return cloud;
}

TorusWithOutliers WithOutliersAnywhere(double noise, size_t outliers) {
  TorusWithOutliers cloud = TorusWithoutOutliers(noise);
  std::mt19937_64 random(13);
  std::uniform_real_distribution<double> part(-1.0, 1.0);
  std::normal_distribution<double> normal;
  for (size_t j = 0; j < outliers; ++j) {
    cloud.points().Add(4.4 * part(random), 4.4 * part(random), 1.2 * part(random), normal(random), normal(random),
                       normal(random));
  }
  return cloud;
}

OutlierOutcome OutcomeOf(const TorusWithOutliers& cloud, const EstimationResult& result) {
  OutlierOutcome outcome;
  size_t estimated = 0;
  for (size_t i = 0; i < cloud.points().size(); ++i) {
    const PointCurvature& point = result.field.points[i];
    const bool is_called_one = point.status == PointStatus::kOutlier;
    if (cloud.IsOutlier(i)) {
      outcome.found += is_called_one ? 1 : 0;
      continue;
    }
    outcome.mistaken += is_called_one ? 1 : 0;
    outcome.without_result += point.status == PointStatus::kOk ? 0 : 1;
    if (point.status != PointStatus::kOk) continue;
    outcome.error += std::abs(point.mean - cloud.torus.mean[i]);
    ++estimated;
  }
  outcome.error /= static_cast<double>(estimated);
  return outcome;
}

size_t CountOutliers(const EstimationResult& result) {
  return result.field.status_counts[static_cast<size_t>(PointStatus::kOutlier)];
}

}  // namespace curvd::testing
