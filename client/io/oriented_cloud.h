// Takes from a table what an estimate needs: packed positions and normals.
#pragma once

#include <cstddef>
#include <variant>
#include <vector>

#include "absl/status/statusor.h"
#include "client/io/point_table.h"

namespace curv {

// Holds x y z of each point, and nx ny nz of each point.
template <typename Scalar>
struct PackedCloud {
  std::vector<Scalar> positions;
  std::vector<Scalar> normals;
};

// A cloud is in floats if the table has x, y and z as floats or as integers that fit into floats, else in doubles.
using OrientedCloud = std::variant<PackedCloud<float>, PackedCloud<double>>;

// Copies positions and normals out of the table. INVALID_ARGUMENT if it lacks a coordinate of either; the message says
// what is missing, what is there, and how normals can be made.
absl::StatusOr<OrientedCloud> ExtractCloud(const PointTable& table);

}  // namespace curv
