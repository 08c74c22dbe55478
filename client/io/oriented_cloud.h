// Takes from a table what a call needs: packed positions, normals, viewpoints and directions.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "absl/status/statusor.h"
#include "client/io/point_table.h"

namespace curv {

// Holds x y z of each point, and, if they are needed, its normal, where it was seen from, and a direction.
template <typename Scalar>
struct PackedCloud {
  std::vector<Scalar> positions;
  std::vector<Scalar> normals;
  std::vector<Scalar> viewpoints;
  std::vector<Scalar> directions;
};

// A cloud is in floats if the table has x, y and z as floats or as integers that fit into floats, else in doubles.
using OrientedCloud = std::variant<PackedCloud<float>, PackedCloud<double>>;

// What is needed of a table beside positions.
struct CloudNeeds {
  bool normals = true;
  bool viewpoints = false;
  std::string directions{};  // NAME of the columns NAMEx NAMEy NAMEz, or NAME_x NAME_y NAME_z; empty: none
};

// Copies what is needed out of the table. INVALID_ARGUMENT if it lacks a coordinate; the message says what is missing,
// what is there, and how normals can be made.
absl::StatusOr<OrientedCloud> ExtractCloud(const PointTable& table, const CloudNeeds& needs = {});

// The names of the columns that tell where each point was seen from: vp_x vp_y vp_z, viewpoint_x ..., sensor_x ... or
// scanner_x ..., the first that are complete; nothing if there are none.
std::optional<std::array<std::string, 3>> FindViewpoints(const PointTable& table);

}  // namespace curv
