// Decides how a table becomes the points of a LAS file.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/io/las/las_columns.h"
#include "client/io/las/las_frame.h"
#include "client/io/point_table.h"

namespace curv {

struct LasSlot {
  LasField field;
  LasSource source;
};

struct LasPlan {
  uint8_t minor_version = 4;
  uint8_t point_format = 6;
  size_t record_bytes = 0;
  std::array<const Column*, 3> coordinates{};
  std::array<LasAxis, 3> axes;
  std::vector<LasSlot> slots;  // without X, Y and Z
  std::string descriptors;     // of extra bytes, 192 bytes each
};

// Plans a file like the one that the table comes from (PointTable::las), with colors if the table has them; for other
// tables one of LAS 1.4, formats 6, 7 or 8, or 0 to 3 if there is a column scan_angle_rank, which the later formats do
// not have. Columns that an attribute of the format holds exactly go there, 8-bit colors as 16-bit ones; all others
// become extra bytes in their types. The plan refers to the table's columns.
// INVALID_ARGUMENT, naming value and limit, if x, y or z are missing or not finite, or if LAS cannot hold so many
// points, attributes or bytes a point.
absl::StatusOr<LasPlan> PlanLas(const PointTable& table);

}  // namespace curv
