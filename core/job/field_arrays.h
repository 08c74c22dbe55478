// Takes a field apart: an array of points becomes an array of each column.
#pragma once

#include <array>
#include <span>

#include "core/estimators/curvature_field.h"
#include "core/estimators/point_choice.h"
#include "core/normals/normals.h"

namespace curvd {

// Where each column's values go, one point behind the other, aligned or not; nullptr: not wanted. In the order of
// kColumns.
using ColumnPlaces = std::array<char*, kColumnCount>;

// Writes the columns of `points` to `places`. The arrays must not overlap. Takes about 3 ns a point.
void SplitField(std::span<const PointCurvature> points, const ColumnPlaces& places);

// The same for choices, in the order of kChoiceColumns.
using ChoicePlaces = std::array<char*, kChoiceColumns.size()>;
void SplitChoices(std::span<const PointChoice> points, const ChoicePlaces& places);

// The same for normals, in the order of kNormalColumns.
using NormalPlaces = std::array<char*, kNormalColumns.size()>;
void SplitNormals(std::span<const PointNormal> points, const NormalPlaces& places);

}  // namespace curvd
