// What an estimate needs of a table: packed positions and normals.
#pragma once

#include <cstddef>
#include <variant>
#include <vector>

#include "absl/status/statusor.h"
#include "client/io/point_table.h"

namespace curv {

// x y z of each point and, as many, nx ny nz of each point.
template <typename Scalar>
struct PackedCloud {
  std::vector<Scalar> positions;
  std::vector<Scalar> normals;
};

// In floats if the table has x, y and z as floats (or integers that fit into floats), else in doubles.
using OrientedCloud = std::variant<PackedCloud<float>, PackedCloud<double>>;

// INVALID_ARGUMENT if the table lacks a coordinate of the positions or normals; the message says what is missing, what
// is there, and how normals can be made.
absl::StatusOr<OrientedCloud> ExtractCloud(const PointTable& table);

}  // namespace curv
