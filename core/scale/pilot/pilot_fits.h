// Fits of polynomials to the neighborhoods of sampled points, several at once, from sums over their neighbors.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "core/estimators/scale_ladder.h"
#include "core/scale/pilot/pilot_sums.h"
#include "core/scale/pilot/pilot_systems.h"

namespace curvd {

// What fits say of one neighborhood; nothing where its neighbors fix no surface. Lengths are in the unit of the
// neighbors.
struct PilotFits {
  struct Regression {
    TangentShape shape;
    std::array<TangentShape, 2> slope;  // how the shape changes along x, and along y
    double residual;                    // standard deviation of the normals about the fit, along each tangent
  };
  struct Jet {
    TangentShape shape;
    double residual;  // standard deviation of the positions about the surface
  };
  // What the weighted cubic regression of the normals estimates, that of degree 2, and the linear one over space.
  std::optional<Regression> regression;
  std::optional<TangentShape> quadratic_regression, linear_regression;
  // What jet fitting of degree 4, 2 and 6 estimates; of degree 6 where there are half as many neighbors more than it
  // has coefficients.
  std::optional<Jet> quartic, quadric, sextic;
};

// Neighborhoods that are fitted together: a vector holds the same number of one, two, four or all eight of them, and
// each has the steps that it would have alone. So what comes out depends neither on the machine nor on the others.
class PilotFitter {
 public:
  static constexpr size_t kMost = PilotSystems::kLanes;

  // Fits by these methods, and by those that tell noise.
  explicit PilotFitter(const MethodSet& methods = AllMethods()) : methods_(methods) {}

  // `radius` is that of the neighborhood, in which `distinct` neighbors have positions of their own: fits and their
  // residuals have as many as that. REQUIRES: the radius is positive, and size() < kMost.
  void Add(const PilotSums& sums, double distinct, double radius);
  void Add(const PilotSums& sums, double radius) { Add(sums, sums.count(), radius); }
  size_t size() const { return size_; }

  // Of each neighborhood in the order of Add; then there are none.
  std::array<PilotFits, kMost> Fit();

 private:
  // Of one number, that of each neighborhood.
  using Lanes = std::array<double, kMost>;
  using Fits = std::array<PilotFits, kMost>;

  void SolveNormals(int degree, PilotSolutions& solutions) const;
  void FitCubicNormals(PilotSolutions& solutions, Fits& fits) const;
  void FitQuadraticNormals(PilotSolutions& solutions, Fits& fits) const;
  void FitJets(int degree, std::optional<PilotFits::Jet> PilotFits::*jet, PilotSolutions& solutions, Fits& fits) const;

  const MethodSet methods_;
  size_t size_ = 0;
  std::array<bool, kMost> with_sextic_{};
  std::array<std::optional<TangentShape>, kMost> linear_;
  // Where there is no neighborhood, they are those of one point.
  alignas(64) Lanes count_{1, 1, 1, 1, 1, 1, 1, 1}, radius_ = count_;
  alignas(64) Lanes distinct_{}, height_squares_{};
  alignas(64) std::array<Lanes, PilotSums::kMomentCount> moments_{};
  alignas(64) std::array<Lanes, PilotSums::kHeightCount> heights_{};
  alignas(64) std::array<std::array<Lanes, PilotSums::kNormalCount>, 3> normals_{};
};

}  // namespace curvd
