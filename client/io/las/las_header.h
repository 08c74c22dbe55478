// Reads the header and the variable length records of a LAS file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "absl/status/statusor.h"
#include "client/io/las/las_frame.h"

namespace curv {

// What was read, all of it checked against the file's size.
struct LasHeader {
  LasFrame frame;        // without `extras`
  size_t points_at = 0;  // byte of the first point
  size_t points = 0;     // points_at + points * record_bytes is at most the file's size, unless they are compressed
  size_t record_bytes = 0;
  bool is_compressed = false;  // LazPoints reads them
  uint32_t chunk_points = 0;   // that the record of LASzip tells; 0 if there is none, or points are not compressed
  size_t end = 0;              // byte after the last thing that the header tells of
  std::string extra_bytes;     // descriptors of all Extra Bytes records, 192 bytes each
};

// Who decompresses points, if they are compressed.
enum class Decompressor {
  kThisProgram,  // which cannot unless CanReadLaz()
  kAnother,
};

// Reads LAS 1.0 to 1.4, point formats 0 to 10, from the whole file. INVALID_ARGUMENT naming the field, its value and
// what was expected if the file is anything else, and, naming what decompresses them, for compressed points (LAZ, COPC)
// that nobody decompresses. The records that tell of compression are left out.
absl::StatusOr<LasHeader> ReadLasHeader(std::string_view file, Decompressor decompressor = Decompressor::kThisProgram);

// Returns whether this is the start of a LAS file whose points are compressed.
bool IsCompressedLas(std::string_view file);

}  // namespace curv
