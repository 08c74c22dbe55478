// What tests of the automatic choice ask for, of which clouds, and how they compare choices.
#pragma once

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

inline bool AreSameBytes(const ChoiceField& a, const ChoiceField& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.bytes()) == 0;
}

}  // namespace curvd::testing
