// The scales and estimators among which an automatic estimate chooses.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace curvd {

// Neighbor counts, each the square root of 2 times the one before.
inline constexpr std::array<uint32_t, 15> kScaleRungs = {16,  23,  32,  45,  64,   91,   128, 181,
                                                         256, 362, 512, 724, 1024, 1448, 2048};
inline constexpr size_t kRungCount = kScaleRungs.size();

// An estimator that the choice knows, and what of it the choice depends on.
struct ScaleMethod {
  std::string_view estimator;
  // Of the polynomials of "jet" and "normal-regression"; 0: of others. The first row of "jet" has the only degree that
  // is taken where that estimator is fixed and its scale is not; of "normal-regression" any row's is.
  uint32_t degree;
  // Rungs to the next estimate that this one is compared with: neighborhoods that share too much show no difference.
  size_t compared_rungs;
  // Noise of standard deviation sigma in the positions moves a point along the surface, and what is estimated at it by
  // about this many times sigma^2 |H| k^2, whatever the scale.
  double noise_factor;
  // Times this, what the sampled points show is the error that is expected of the mean curvature, and of the Gaussian
  // one: more than 1 where a bias that they cannot show is likelier than elsewhere.
  double doubt = 1.0, gaussian_doubt = 1.0;

  // Whether the error of a smooth surface falls as the square of the radius only: the farther estimates look, the more
  // they all err to one side.
  constexpr bool is_second_order() const { return compared_rungs == 2; }
  // Whether it may look all around a body.
  constexpr bool is_doubted() const { return doubt > 1.0; }
  constexpr bool is_jet() const { return estimator == "jet"; }
  constexpr bool is_regression() const { return estimator == "normal-regression"; }
  constexpr bool is_sphere() const { return estimator == "aso"; }  // projected on the surface
};

inline constexpr std::array<ScaleMethod, 8> kScaleMethods = {{
    {"avg-hexagram", 0, 2, 0.3},
    {"normal-regression", 3, 1, 8.0},
    {"jet", 4, 1, 96.0},
    {"jet", 2, 2, 3.0},
    {"jet", 6, 1, 300.0},
    {"normal-regression", 2, 2, 3.0},
    {"normal-regression", 1, 2, 0.3, 2.0, 4.0},
    {"aso", 0, 2, 0.5, 1.2},
}};
inline constexpr size_t kMethodCount = kScaleMethods.size();
inline constexpr size_t kHexagramMethod = 0, kRegressionMethod = 1, kQuarticMethod = 2, kQuadricMethod = 3,
                        kSexticMethod = 4, kQuadraticRegressionMethod = 5, kLinearRegressionMethod = 6,
                        kSphereMethod = 7;

// Some of the methods.
using MethodSet = std::array<bool, kMethodCount>;
constexpr MethodSet AllMethods() {
  MethodSet all{};
  all.fill(true);
  return all;
}

// Jets of degree 6 take no more neighbors. They are for exact positions, where they need few, and cost the most by far.
inline constexpr uint32_t kMostSexticCount = 256;

// One way to estimate: an estimator at a scale.
struct ScaleCandidate {
  size_t method;
  size_t rung;
  uint32_t count() const { return kScaleRungs[rung]; }
  friend bool operator==(const ScaleCandidate&, const ScaleCandidate&) = default;
};

}  // namespace curvd
