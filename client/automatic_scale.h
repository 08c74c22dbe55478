// Neighborhoods whose size the server chooses, and what it says about its choice.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client/normal_options.h"

namespace curv {

// As many nearest points as noise and detail ask for, at each point.
struct AutomaticScale {
  // 16 to 2,048; 0: the least and the most that the server takes. DEFAULT: 0.
  uint32_t least_neighbor_count = 0;
  uint32_t most_neighbor_count = 0;
  // How far an estimate looks at most, in the cloud's length unit; 0: any distance. DEFAULT: 0.
  double max_radius = 0.0;
  // The same choice for all points. DEFAULT: false.
  bool per_cloud = false;
};

// One way to estimate that the server has judged, by a sample of the points. Errors are of the mean curvature.
struct ScaleOutcome {
  std::string estimator;  // as EstimatorName has it; its number if this client is too old for it
  // Of the polynomials of "jet", 2, 4 or 6, which the choice alone takes, and of "normal-regression", 1 to 3; 0: of
  // other estimators, or of servers too old to tell it.
  uint32_t degree = 0;
  uint32_t neighbor_count = 0;
  double error = 0.0;  // that is expected
  double noise = 0.0;  // how much of it is noise
  double bias = 0.0;   // how much of it is detail that is smoothed away
  double share = 0.0;  // mean weight in the results; 0: not chosen
};

// The fits to noisy positions that given normals prove to be those of.
struct FittedNormals {
  NormalMethod method = NormalMethod::kPca;
  uint32_t neighbor_count = 0;  // the point itself included
};

struct ScaleReport {
  // By estimator and degree, then by neighbor count; empty: nothing could be judged.
  std::vector<ScaleOutcome> outcomes;
  uint32_t sampled_points = 0;
  double position_noise = 0.0;           // standard deviation from the fitted surfaces, in the cloud's length unit
  std::optional<double> normal_noise{};  // of normals, along each tangent, in radians; none: the cloud is too small
  std::optional<FittedNormals> fitted_normals{};  // none: given normals prove to be those of no fit, or none were given
  std::optional<FittedNormals> normals_made_anew{};  // by which the server has made given ones anew; none: it has not
};

}  // namespace curv
