// Estimates at one sampled point from sums over its neighbors, which grow from scale to scale. In doubles, and made in
// the same way on every machine: so must be what is chosen by them.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "Eigen/Core"
#include "core/scale/pilot_batch.h"

namespace curvd {

// The shape operator over the frame's x and y, [[mean + difference, twist], [twist, mean - difference]].
struct TangentShape {
  double mean;
  double difference;
  double twist;
};

// Sums over neighbors. Usage: Add them, or add up the sums of parts; then ask for estimates.
class PilotSums {
 public:
  // The sums depend on which neighbors a batch holds, and in what order. What follows them in it is overwritten.
  void Add(PilotBatch& batch) { AddUpTo(kSexticDegree, batch); }
  // The same in less time, without a SexticEstimate from there on.
  void AddWithoutSextic(PilotBatch& batch) { AddUpTo(kQuarticDegree, batch); }
  void Add(const PilotNeighbor& neighbor) {
    PilotBatch batch;
    batch.Add(neighbor);
    Add(batch);
  }
  PilotSums& operator+=(const PilotSums& other);

  double count() const { return values_[kCount]; }
  // Whether the neighbors lie along a line, as those on one line of a scanner do: a tenth as wide as long at most, and
  // no wider than twice what they spread along the normal. They show nothing of the curvature across it.
  bool LieAlongLine() const;

  // In each case lengths are in the unit of the neighbors, `radius` is that of the neighborhood, and nothing is
  // returned where the neighbors fix no surface.
  struct Hexagrams {
    TangentShape shape;
    double steepest;  // the larger principal curvature by magnitude
  };
  // What avg-hexagram with two rotations estimates.
  std::optional<Hexagrams> HexagramEstimate() const;
  struct Regression {
    TangentShape shape;
    std::array<TangentShape, 2> slope;  // how the shape changes along x, and along y
    double residual;                    // standard deviation of the normals about the fit, along each tangent
  };
  // What the weighted cubic regression of the normals estimates.
  std::optional<Regression> RegressionEstimate(double radius) const;
  // The same of degree 2.
  std::optional<TangentShape> QuadraticRegressionEstimate(double radius) const;
  struct Jet {
    TangentShape shape;
    double residual;  // standard deviation of the positions about the surface
  };
  // What jet fitting of degree 4 estimates.
  std::optional<Jet> JetEstimate(double radius) const { return FitJet<4>(radius); }
  // What jet fitting of degree 2 estimates.
  std::optional<Jet> QuadricEstimate(double radius) const { return FitJet<2>(radius); }
  // What jet fitting of degree 6 estimates, where there are half as many neighbors more than it has coefficients.
  std::optional<Jet> SexticEstimate(double radius) const;

 private:
  static constexpr int kQuarticDegree = 4, kSexticDegree = 6;
  // Sums of x^i y^j, of z x^i y^j, and of each component of the normal times x^i y^j, up to these degrees.
  static constexpr int kMomentDegree = 2 * kSexticDegree, kHeightDegree = kSexticDegree,
                       kNormalDegree = PilotMoments::kNormalDegree;
  static constexpr size_t kSectors = 12, kSectorValues = 7;
  // Places in values_.
  static constexpr size_t kCount = 0, kSexticCount = 1, kHeightSquares = 2, kMoments = 3,
                          kHeights = kMoments + MonomialCount(kMomentDegree),
                          kNormals = kHeights + MonomialCount(kHeightDegree),
                          kSectorSums = kNormals + 3 * MonomialCount(kNormalDegree),
                          kValues = kSectorSums + kSectors * kSectorValues;

  // Adds to the sums that a jet of that degree is made of, and to all that jets need none of.
  void AddUpTo(int degree, PilotBatch& batch);

  // Polynomials over the tangent plane, whose unit of length is the radius: a column of coefficients for each component
  // of the normal, which has unit length at the point.
  template <int kDegree>
  struct NormalFit {
    Eigen::Matrix<double, static_cast<int>(MonomialCount(kDegree)), 3> coefficients;
    double residual;  // as Regression::residual
  };
  template <int kDegree>
  std::optional<NormalFit<kDegree>> FitNormals(double radius) const;
  template <int kDegree>
  std::optional<Jet> FitJet(double radius) const;

  struct Corner {
    std::array<double, 3> position;
    std::array<double, 3> normal;
  };
  Corner CornerOf(size_t sector) const;

  std::array<double, kValues> values_{};
};

}  // namespace curvd
