// Tells a sheet whose normals change sides from two sheets of a thin part, whose normals are opposed by right.
#pragma once

#include <cstddef>

namespace curvd {

// Two unit normals are opposed, or agree, if the cosine of their angle is below -kAlong, or above kAlong: 135 and 45
// degrees. Below 135 degrees, right normals of an edge are common, and so is noise.
inline constexpr float kAlong = 0.7f;
// Below -kMayOppose, 120 degrees, they may be opposed where the surface bends as well.
inline constexpr float kMayOppose = 0.5f;

// Heights of some neighbors of a point: how far they lie from its sheet, along the normals of both. Sums in doubles.
class SheetHeights {
 public:
  void Add(double height) {
    ++count_;
    sum_ += height;
    squares_ += height * height;
  }
  size_t count() const { return count_; }
  // 0 without neighbors.
  double Mean() const;
  // The standard deviation.
  double Spread() const;

 private:
  size_t count_ = 0;
  double sum_ = 0.0;
  double squares_ = 0.0;
};

// Returns whether neighbors with opposed normals lie on the point's own sheet, so that it is beside a seam. `agreeing`
// are the heights of neighbors with normals that agree, the point included: for an offset d and normals n, n' they are
// d (n + n') / 2. `opposed` are those of neighbors with opposed normals: d (n - n') / 2. On a circle that is 0, and on
// any smooth sheet far less than d. `distance`: the mean distance of the opposed ones. docs/numerics/seams.md derives
// the bounds. REQUIRES: opposed.count() > 0.
bool LieOnOneSheet(const SheetHeights& agreeing, const SheetHeights& opposed, double distance);
// The same in doubt: false only where they lie so high that no noise explains it.
bool MayLieOnOneSheet(const SheetHeights& agreeing, const SheetHeights& opposed, double distance);
// The same of one neighbor alone, with a normal that agrees or is opposed, by its height and distance.
bool MayLieOnOneSheet(double height, double distance);

}  // namespace curvd
