// What follows from the principal curvatures of a point, for whoever asks for it.
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "core/estimators/curvature_field.h"

namespace curvd {

// The shape index of Koenderink and van Doorn ("Surface shape and curvature scales", 1992), 2 / pi * atan((k1 + k2) /
// (k2 - k1)): which shape the surface has, whatever its size. In [-1, 1]: 1 a cap (convex, as a ball from outside), 0.5
// a ridge, 0 a saddle, -0.5 a rut, -1 a cup. NaN where both are 0: a plane has no shape.
float ShapeIndex(const PointCurvature& point);

// The curvedness of the same authors, sqrt((k1^2 + k2^2) / 2): how much the surface bends, whatever its shape. In 1 /
// the caller's length unit; 0 for a plane, 1 / r for a ball of radius r.
float Curvedness(const PointCurvature& point);

// A column that is computed when results are sent, and takes no memory before. One float32 a point; NaN where the
// status is not kOk.
struct DerivedColumn {
  std::string_view name;
  float (*value)(const PointCurvature& point);
};
inline constexpr std::array kDerivedColumns = {
    DerivedColumn{"shape_index", &ShapeIndex},
    DerivedColumn{"curvedness", &Curvedness},
};

// Where each of those columns goes, aligned or not; nullptr: not wanted.
using DerivedPlaces = std::array<char*, kDerivedColumns.size()>;
void DeriveColumns(std::span<const PointCurvature> points, const DerivedPlaces& places);

}  // namespace curvd
