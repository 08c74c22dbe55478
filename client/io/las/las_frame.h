// Holds what a LAS file says beside the values of its points, so that a file that is made of it says it too.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace curv {

// The lattice on which the coordinates of one axis lie: coordinate = raw * scale + offset.
struct LasAxis {
  double scale = 1.0;   // length units, finite, above 0
  double offset = 0.0;  // length units, finite

  double At(int32_t raw) const { return raw * scale + offset; }
};

// A variable length record, extended (after the points) or not.
struct LasRecord {
  std::string user_id;  // as in the file, 16 bytes with zeros at the end
  uint16_t id = 0;
  std::string description;  // 32 bytes likewise
  std::string payload;
  bool extended = false;

  // Returns whether this is record `record_id` of the user `user`.
  bool Is(std::string_view user, uint16_t record_id) const;
};

// One attribute beyond those of the point format, as an Extra Bytes record describes it.
struct LasExtra {
  std::string descriptor;            // 192 bytes
  std::vector<std::string> columns;  // of the table, one a component; one a byte where the bytes are undocumented

  uint8_t data_type() const { return static_cast<uint8_t>(descriptor[2]); }
};

// The numbers in comments are those of the fields' first bytes in the header.
struct LasFrame {
  uint16_t file_source_id = 0;                            // 4
  uint16_t global_encoding = 0;                           // 6
  std::string project_id = std::string(16, '\0');         // 8
  uint8_t minor_version = 4;                              // 25
  std::string system_identifier = std::string(32, '\0');  // 26
  uint16_t creation_day = 0;                              // 90
  uint16_t creation_year = 0;                             // 92
  uint8_t point_format = 6;                               // 104
  std::array<LasAxis, 3> axes;                            // 131
  std::string header_rest;                                // what follows the header's known fields
  std::vector<LasRecord> records;                         // but for those that describe extra bytes
  std::vector<LasExtra> extras;                           // in the order of their bytes in a point
  std::optional<size_t> waveform_record;                  // which of the records holds waveform packets
};

// Returns the bytes that the header of LAS 1.minor_version has: 227, 235 or 375.
size_t LasHeaderBytes(uint8_t minor_version);

inline constexpr size_t kLasRecordHeaderBytes = 54;
inline constexpr size_t kLasExtendedRecordHeaderBytes = 60;
inline constexpr char kLasSpecUser[] = "LASF_Spec";
inline constexpr uint16_t kLasExtraBytesId = 4;

}  // namespace curv
