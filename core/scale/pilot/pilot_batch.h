// Neighbors of a sampled point whose powers are summed together, with vectors.
#pragma once

#include <array>
#include <cstddef>

namespace curvd {

// A neighbor in the frame of the tangent plane at the sampled point, which is the origin; z along the normal.
struct PilotNeighbor {
  std::array<double, 3> offset;  // in units in which the largest neighborhood has radius 1
  std::array<double, 3> normal;  // of unit length
};

// Monomials x^i y^j up to a degree.
constexpr size_t MonomialCount(int degree) { return static_cast<size_t>((degree + 1) * (degree + 2) / 2); }

// Neighbors, coordinate by coordinate. Uninitialized, but for their count.
struct PilotBatch {
  static constexpr size_t kMost = 128;
  // Sums are made in so many parts, of each of which a vector holds one or several: the same on every machine.
  static constexpr size_t kParts = 8;
  using Column = std::array<double, kMost>;

  alignas(64) Column one;  // 1 for each neighbor
  alignas(64) std::array<Column, 3> offset, normal;
  size_t count = 0;

  bool is_full() const { return count == kMost; }
  // REQUIRES: it is not full.
  void Add(const PilotNeighbor& neighbor) {
    one[count] = 1.0;
    for (size_t axis = 0; axis < 3; ++axis) {
      offset[axis][count] = neighbor.offset[axis];
      normal[axis][count] = neighbor.normal[axis];
    }
    ++count;
  }
  // Makes what follows the last neighbor, up to a multiple of kParts, count for nothing. Returns that multiple.
  size_t Pad() {
    const size_t padded = (count + kParts - 1) / kParts * kParts;
    for (size_t k = count; k < padded; ++k) {
      one[k] = 0.0;
      for (size_t axis = 0; axis < 3; ++axis) offset[axis][k] = normal[axis][k] = 0.0;
    }
    return padded;
  }
  // The sum of kParts partial sums.
  static double Total(const double* part) {
    return ((part[0] + part[4]) + (part[2] + part[6])) + ((part[1] + part[5]) + (part[3] + part[7]));
  }
};

// Where sums go, as graded monomials: of x^i y^j up to the degree 2 * `degree`, of z x^i y^j up to `degree`, and of
// each component of the normal times x^i y^j up to `normal_degree`.
struct PilotMoments {
  static constexpr int kMostDegree = 6;
  int degree;
  int normal_degree;
  double* plain;
  double* height;  // null: nobody asks
  std::array<double*, 3> normal;
};

// Adds the neighbors to the sums: products are rounded before they are added, and added in an order that depends on the
// neighbors' order and number alone, so that the sums are the same on every machine. What follows the neighbors in the
// batch is overwritten. REQUIRES: degree <= kMostDegree; normal_degree <= 2 * degree; heights, if there are any, have
// places up to normal_degree in any case.
void AddMoments(PilotBatch& batch, const PilotMoments& sums);

}  // namespace curvd
