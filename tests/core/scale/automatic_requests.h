// What tests of the automatic choice ask for, of which clouds, and how they compare choices.
#pragma once

#include <cmath>
#include <cstring>

#include "core/estimators/options.h"
#include "core/estimators/point_choice.h"
#include "tests/core/normals/normal_clouds.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {

inline EstimatorOptions Automatic(AutomaticScale scale = {}) {
  return {.estimator = kAutomaticEstimator, .neighborhood = scale};
}

inline EstimatorOptions WithChoice(EstimatorOptions options) {
  options.returns_choice = true;
  return options;
}

// A unit sphere with noise of its positions.
inline TestPoints NoisySphere(size_t points, double sigma) {
  TestPoints sphere = Sphere(points, 1.0);
  AddNoise(sigma, 3, sphere);
  return sphere;
}

// A sphere that is exact where x is negative.
inline TestPoints HalfNoisySphere(size_t points) {
  TestPoints halves = NoisySphere(points, 0.0);
  const TestPoints noisy = NoisySphere(points, 0.01);
  for (size_t i = 0; i < points; ++i) {
    if (halves.positions[i][0] < 0.0f) continue;
    halves.positions[i] = noisy.positions[i];
    halves.normals[i] = noisy.normals[i];
  }
  return halves;
}

inline bool AreSameBytes(const ChoiceField& a, const ChoiceField& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.bytes()) == 0;
}

inline float SumOfWeights(const PointChoice& choice) {
  return choice.avg_hexagram_weight + choice.normal_regression_weight + choice.jet_weight + choice.aso_weight;
}

// Of the mean curvature, over the points that have one.
inline double MeanError(const EstimationResult& result, double truth) {
  double sum = 0.0;
  size_t count = 0;
  for (const PointCurvature& point : result.field.points.span()) {
    if (point.status != PointStatus::kOk) continue;
    sum += std::abs(point.mean - truth);
    ++count;
  }
  return sum / static_cast<double>(count);
}

}  // namespace curvd::testing
