// Sums over the neighbors of one sampled point, which grow from scale to scale. In doubles, and made in
// the same way on every machine: so must be what is chosen by them.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "core/scale/pilot/pilot_batch.h"
#include "core/scale/shapes/tangent_shape.h"

namespace curvd {

// Sums over neighbors. Usage: Add them, or add up the sums of parts; then ask for estimates.
class PilotSums {
 public:
  // The sums depend on which neighbors a batch holds, and in what order. What follows them in it is overwritten.
  void Add(PilotBatch& batch) { AddUpTo(kSexticDegree, batch); }
  // The same in less time, without what jets of degree 6 need from there on.
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

  // Sums of x^i y^j, of z x^i y^j, and of each component of the normal times x^i y^j, as graded monomials.
  static constexpr int kQuarticDegree = 4, kSexticDegree = 6, kNormalDegree = 5;
  static constexpr size_t kMomentCount = MonomialCount(2 * kSexticDegree), kHeightCount = MonomialCount(kSexticDegree),
                          kNormalCount = MonomialCount(kNormalDegree);
  const double* moments() const { return &values_[kMoments]; }
  const double* heights() const { return &values_[kHeights]; }
  const double* normals(size_t axis) const { return &values_[kNormals + axis * kNormalCount]; }
  // Of z squared, and of z times each component of the normal.
  double height_squares() const { return values_[kHeightSquares]; }
  double normal_heights(size_t axis) const { return values_[kNormalHeights + axis]; }
  // Whether sums beyond what a jet of degree 4 is made of are there: of all neighbors.
  bool has_sextic() const { return values_[kSexticCount] == count(); }

 private:
  static constexpr size_t kSectors = 12, kSectorValues = 7;
  // Places in values_.
  static constexpr size_t kCount = 0, kSexticCount = 1, kHeightSquares = 2, kNormalHeights = 3, kMoments = 6,
                          kHeights = kMoments + kMomentCount, kNormals = kHeights + kHeightCount,
                          kSectorSums = kNormals + 3 * kNormalCount, kValues = kSectorSums + kSectors * kSectorValues;

  // Adds to the sums that a jet of that degree is made of, and to all that jets need none of.
  void AddUpTo(int degree, PilotBatch& batch);

  // Of the sixth of the circle that begins at each twelfth: the position, then the normal, by component.
  using Corners = std::array<std::array<double, kSectors>, 6>;
  Corners CornersOfSixths() const;

  std::array<double, kValues> values_{};
};

}  // namespace curvd
