// Says where the attributes of a LAS point lie in its record (ASPRS LAS 1.4 R15, "Point Data Records").
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace curv {

inline constexpr uint8_t kMaxLasFormat = 10;

// Types of scalars; the values are those of `data_type` in an Extra Bytes record.
enum class LasType : uint8_t {
  kUint8 = 1,
  kInt8,
  kUint16,
  kInt16,
  kUint32,
  kInt32,
  kUint64,
  kInt64,
  kFloat32,
  kFloat64
};

size_t BytesOf(LasType type);

// Calls visit(T{}), where T is the C++ type.
template <typename Visit>
void WithType(LasType type, const Visit& visit) {
  switch (type) {
    case LasType::kUint8:
      return visit(uint8_t{});
    case LasType::kInt8:
      return visit(int8_t{});
    case LasType::kUint16:
      return visit(uint16_t{});
    case LasType::kInt16:
      return visit(int16_t{});
    case LasType::kUint32:
      return visit(uint32_t{});
    case LasType::kInt32:
      return visit(int32_t{});
    case LasType::kUint64:
      return visit(uint64_t{});
    case LasType::kInt64:
      return visit(int64_t{});
    case LasType::kFloat32:
      return visit(float{});
    case LasType::kFloat64:
      return visit(double{});
  }
}

// value = stored * scale + offset; a stored `no_data` means that there is no value, which is NaN in a table.
struct LasScaling {
  double scale = 1.0;
  double offset = 0.0;
  std::optional<double> no_data;
};

struct LasField {
  std::string name;  // of the table's column
  LasType type = LasType::kUint8;
  size_t offset = 0;      // bytes from the start of the record
  uint8_t first_bit = 0;  // of a field within a byte
  uint8_t bits = 0;       // its bits; 0: the field is not within a byte
  std::optional<LasScaling> scaling;

  // 64-bit integers have no column of their kind; see LasColumnReader.
  bool is_wide() const { return !scaling.has_value() && (type == LasType::kUint64 || type == LasType::kInt64); }
};

// Returns the bytes that a record of `format` has at least. REQUIRES: format <= kMaxLasFormat.
size_t LasRecordBytes(uint8_t format);

// Returns the attributes of a format in the order of their bytes, without X, Y and Z, which come first.
// REQUIRES: format <= kMaxLasFormat.
std::vector<LasField> StandardFields(uint8_t format);

// Returns the format that has the attributes of `format` and colors too.
uint8_t WithColors(uint8_t format);

}  // namespace curv
