// Tells what each record of a LAS, LAZ or COPC file holds, once it is decompressed.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "client/io/las/las_fields.h"
#include "client/io/las/las_frame.h"
#include "client/io/las/las_header.h"

namespace curv {

struct LasLayout {
  LasHeader header;                // without the descriptors of extra bytes
  std::vector<LasExtra> extras;    // what they describe
  std::vector<LasField> fields;    // of a record, behind X, Y and Z; names are unique
  std::vector<std::string> notes;  // what a table cannot hold of it, and what is odd about the coordinates
};

// Reads the layout of a whole file. Errors are those of ReadLasHeader.
absl::StatusOr<LasLayout> ReadLasLayout(std::string_view file, Decompressor decompressor = Decompressor::kThisProgram);

// The bounding box as the header tells it; nothing checks it.
struct LasBox {
  std::array<double, 3> low;
  std::array<double, 3> high;
};
// REQUIRES: ReadLasHeader succeeds.
LasBox BoxOfHeader(std::string_view file);

// What follows the number of points that are marked as withheld, in a note.
inline constexpr char kWithheldNote[] =
    " points are marked as withheld, which is to say deleted: they take part like others";

}  // namespace curv
