#include "tests/client/io/las/las_samples.h"

#include "tests/client/io/samples.h"

namespace curv {
namespace {

std::string Field(std::string text, size_t bytes) {
  text.resize(bytes, '\0');
  return text;
}

uint8_t Byte(int value) { return static_cast<uint8_t>(value); }

std::string RecordBytes(const SampleRecord& record, bool extended) {
  const std::string length = extended ? Pack(static_cast<uint64_t>(record.payload.size()))
                                      : Pack(static_cast<uint16_t>(record.payload.size()));
  return Pack(uint16_t{0}) + Field(record.user_id, 16) + Pack(record.id) + length + Field("made by hand", 32) +
         record.payload;
}

// Bytes 12 to 19 of formats 0 to 5.
std::string LegacyCore(int i) {
  return Pack(static_cast<uint16_t>(40000 + i), Byte(2 | 3 << 3 | 1 << 6), Byte((2 + i) | 1 << 6),
              static_cast<int8_t>(-30 + i), uint8_t{77}, static_cast<uint16_t>(600 + i));
}

// Bytes 12 to 21 of formats 6 to 10.
std::string Core(int i) {
  return Pack(static_cast<uint16_t>(40000 + i), Byte(2 | 3 << 4), Byte(1 << 1 | 2 << 4 | 1 << 6), Byte(2 + i),
              uint8_t{77}, static_cast<int16_t>(-30 + i), static_cast<uint16_t>(600 + i));
}

std::string Waveform(int i) {
  return Pack(uint8_t{1}) + Pack((uint64_t{1} << 40) * static_cast<uint64_t>(i) + 60) + Pack(uint32_t{64}) +
         Pack(0.5f, 0.25f, -0.5f, 1.0f);
}

}  // namespace

std::string SamplePoint(int format, int i, const std::string& extra) {
  const std::string time = Pack(1.25e8 + i / 8.0);
  const std::string colors = Pack(uint16_t{256}, uint16_t{65535}, static_cast<uint16_t>(10 + i));
  const std::string infrared = Pack(static_cast<uint16_t>(30000 + i));
  std::string record = Pack(int32_t{1000 + 7 * i}, int32_t{-2000 + i}, int32_t{50 * i});
  record += format < 6 ? LegacyCore(i) : Core(i);
  if (format == 1 || format >= 3) record += time;
  if (format == 2 || format == 3 || format == 5 || format == 7 || format == 8 || format == 10) record += colors;
  if (format == 8 || format == 10) record += infrared;
  if (format == 4 || format == 5 || format == 9 || format == 10) record += Waveform(i);
  return record + extra;
}

std::string SampleLas::Bytes() const {
  const size_t header_bytes = minor_version == 4 ? 375 : minor_version == 3 ? 235 : 227;
  std::string before_points, points_bytes, after_points;
  for (const SampleRecord& record : records) before_points += RecordBytes(record, false);
  for (const std::string& point : points) points_bytes += point;
  const uint64_t points_at = header_bytes + before_points.size();
  const uint64_t extended_at = points_at + points_bytes.size();
  uint64_t waveforms_at = 0;
  for (size_t i = 0; i < extended_records.size(); ++i) {
    if (i + 1 == waveforms_in) waveforms_at = extended_at + after_points.size();
    after_points += RecordBytes(extended_records[i], true);
  }
  const auto count = static_cast<uint32_t>(points.size());
  const bool legacy = format < 6;

  std::string header = "LASF";
  header += Pack(uint16_t{12}, static_cast<uint16_t>(format >= 6 ? 17 : 1));  // source id, global encoding
  header += "sixteen bytes id";
  header += Pack(uint8_t{1}, Byte(minor_version));
  header += Field("scanner", 32) + Field("by hand", 32);
  header += Pack(uint16_t{33}, uint16_t{2020}, static_cast<uint16_t>(header_bytes), static_cast<uint32_t>(points_at),
                 static_cast<uint32_t>(records.size()), Byte(format),
                 static_cast<uint16_t>(points.empty() ? 0 : points[0].size()));
  header += Pack(legacy ? count : 0u, 0u, legacy ? count : 0u, 0u, 0u, 0u);  // all are second returns
  for (const double value : scale) header += Pack(value);
  for (const double value : offset) header += Pack(value);
  for (int axis = 0; axis < 3; ++axis) header += Pack(1e9, -1e9);  // extremes that nobody relies on
  if (minor_version >= 3) header += Pack(waveforms_at);
  if (minor_version == 4) {
    header += Pack(extended_records.empty() ? uint64_t{0} : extended_at, static_cast<uint32_t>(extended_records.size()),
                   uint64_t{count}, uint64_t{0}, uint64_t{count});
    for (int number = 3; number <= 15; ++number) header += Pack(uint64_t{0});
  }
  return header + before_points + points_bytes + after_points;
}

SampleLas SmallLas(int format) {
  SampleLas las;
  las.format = format;
  las.minor_version = format < 4 ? 2 : format < 6 ? 3 : 4;
  las.points = {SamplePoint(format, 0), SamplePoint(format, 1)};
  return las;
}

std::string Descriptor(int data_type, const std::string& name, int options, double scale, double offset) {
  return Pack(uint16_t{0}, Byte(data_type), Byte(options)) + Field(name, 32) + std::string(4 + 24 + 24 + 24, '\0') +
         Pack(scale) + std::string(16, '\0') + Pack(offset) + std::string(16, '\0') + Field("by hand", 32);
}

}  // namespace curv
