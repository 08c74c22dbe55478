#include "client/io/las/las_fields.h"

#include <iterator>

namespace curv {
namespace {

bool HasTime(uint8_t format) { return format >= 3 || format == 1; }
bool HasColors(uint8_t format) { return WithColors(format) == format; }
bool HasInfrared(uint8_t format) { return format == 8 || format == 10; }
bool HasWaveforms(uint8_t format) { return format == 4 || format == 5 || format >= 9; }

// Appends fields one after the other.
class FieldList {
 public:
  void Add(const char* name, LasType type) {
    fields_.push_back({.name = name, .type = type, .offset = at_, .scaling = {}});
    at_ += BytesOf(type);
  }
  // Adds fields that share a byte, the lowest bits first.
  void AddByte(std::initializer_list<std::pair<const char*, uint8_t>> parts) {
    uint8_t bit = 0;
    for (const auto& [name, bits] : parts) {
      fields_.push_back({.name = name, .offset = at_, .first_bit = bit, .bits = bits, .scaling = {}});
      bit = static_cast<uint8_t>(bit + bits);
    }
    ++at_;
  }
  size_t bytes() const { return at_; }
  std::vector<LasField> Release() { return std::move(fields_); }

 private:
  size_t at_ = 3 * sizeof(int32_t);  // behind X, Y and Z
  std::vector<LasField> fields_;
};

void AddLegacyCore(FieldList& list) {
  list.Add("intensity", LasType::kUint16);
  list.AddByte(
      {{"return_number", 3}, {"number_of_returns", 3}, {"scan_direction_flag", 1}, {"edge_of_flight_line", 1}});
  list.AddByte({{"classification", 5}, {"synthetic", 1}, {"key_point", 1}, {"withheld", 1}});
  list.Add("scan_angle_rank", LasType::kInt8);
  list.Add("user_data", LasType::kUint8);
  list.Add("point_source_id", LasType::kUint16);
}

void AddCore(FieldList& list) {
  list.Add("intensity", LasType::kUint16);
  list.AddByte({{"return_number", 4}, {"number_of_returns", 4}});
  list.AddByte({{"synthetic", 1},
                {"key_point", 1},
                {"withheld", 1},
                {"overlap", 1},
                {"scanner_channel", 2},
                {"scan_direction_flag", 1},
                {"edge_of_flight_line", 1}});
  list.Add("classification", LasType::kUint8);
  list.Add("user_data", LasType::kUint8);
  list.Add("scan_angle", LasType::kInt16);
  list.Add("point_source_id", LasType::kUint16);
}

FieldList ListOf(uint8_t format) {
  FieldList list;
  format >= 6 ? AddCore(list) : AddLegacyCore(list);
  if (HasTime(format)) list.Add("gps_time", LasType::kFloat64);
  if (HasColors(format)) {
    for (const char* color : {"red", "green", "blue"}) list.Add(color, LasType::kUint16);
  }
  if (HasInfrared(format)) list.Add("nir", LasType::kUint16);
  if (HasWaveforms(format)) {
    list.Add("wave_descriptor", LasType::kUint8);
    list.Add("wave_offset", LasType::kUint64);
    list.Add("wave_bytes", LasType::kUint32);
    for (const char* name : {"wave_return_location", "wave_x_t", "wave_y_t", "wave_z_t"}) {
      list.Add(name, LasType::kFloat32);
    }
  }
  return list;
}

}  // namespace

size_t BytesOf(LasType type) {
  size_t bytes = 0;
  WithType(type, [&bytes](auto scalar) { bytes = sizeof(scalar); });
  return bytes;
}

size_t LasRecordBytes(uint8_t format) { return ListOf(format).bytes(); }

std::vector<LasField> StandardFields(uint8_t format) { return ListOf(format).Release(); }

uint8_t WithColors(uint8_t format) {
  static constexpr uint8_t kFormats[] = {2, 3, 2, 3, 5, 5, 7, 7, 8, 10, 10};
  return kFormats[format];
}

}  // namespace curv
