#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "client/io/bytes.h"
#include "client/io/formats.h"
#include "client/io/las/extra_bytes.h"
#include "client/io/las/las_columns.h"
#include "client/io/las/las_header.h"
#include "client/io/las/laz_points.h"

namespace curv {
namespace {

// Rows that are taken apart at a time, so that they are read from memory once.
constexpr size_t kBlockRows = 4096;

// The fields of a point behind X, Y and Z: those of its format, then the extra ones.
std::vector<LasField> AllFields(const LasFrame& frame, size_t extras_at, const std::vector<LasExtra>& extras) {
  std::vector<LasField> fields = StandardFields(frame.point_format);
  for (const LasExtra& extra : extras) {
    for (LasField& field : FieldsOf(extra, extras_at)) fields.push_back(std::move(field));
    extras_at += BytesOf(extra);
  }
  return fields;
}

std::set<std::string> StandardNames(uint8_t format) {
  std::set<std::string> names = {"x", "y", "z"};
  for (const LasField& field : StandardFields(format)) {
    names.insert(field.name);
    if (field.is_wide()) names.insert({field.name + "_low", field.name + "_high"});
  }
  return names;
}

void AppendCoordinates(const LasAxis& axis, const char* first, size_t count, size_t stride,
                       std::vector<double>& values) {
  for (size_t i = 0; i < count; ++i) {
    int32_t raw;
    std::memcpy(&raw, first + i * stride, sizeof(raw));
    values.push_back(axis.At(raw));
  }
}

// Gives the records of a file block by block, from the file itself or decompressed.
class RecordBlocks {
 public:
  static absl::StatusOr<RecordBlocks> Open(std::string_view file, const LasHeader& header) {
    RecordBlocks blocks(file.substr(header.points_at), header.record_bytes);
    if (header.is_compressed && header.points > 0) {
      auto compressed = LazPoints::Open(file, header.points, header.record_bytes);
      if (!compressed.ok()) return compressed.status();
      blocks.compressed_ = *std::move(compressed);
      blocks.block_.resize(kBlockRows * header.record_bytes);
    }
    return blocks;
  }

  // Returns `count` records from `begin` on, where the last call's ended. They stay until the next call.
  // REQUIRES: count <= kBlockRows.
  absl::StatusOr<const char*> Next(size_t begin, size_t count) {
    if (compressed_ == nullptr) return points_.data() + begin * record_bytes_;
    if (absl::Status status = compressed_->Next(count, block_.data()); !status.ok()) return status;
    return block_.data();
  }

 private:
  RecordBlocks(std::string_view points, size_t record_bytes) : points_(points), record_bytes_(record_bytes) {}

  std::string_view points_;
  size_t record_bytes_;
  std::unique_ptr<LazPoints> compressed_;
  std::vector<char> block_;
};

absl::Status ReadPoints(std::string_view file, const LasHeader& header, const std::vector<LasField>& fields,
                        PointTable& table) {
  absl::StatusOr<RecordBlocks> blocks = RecordBlocks::Open(file, header);
  if (!blocks.ok()) return blocks.status();
  std::vector<double> coordinates[3];
  for (std::vector<double>& values : coordinates) values.reserve(header.points);
  std::vector<LasColumnReader> readers(fields.begin(), fields.end());
  for (LasColumnReader& reader : readers) reader.Reserve(header.points);
  for (size_t begin = 0; begin < header.points; begin += kBlockRows) {
    const size_t count = std::min(kBlockRows, header.points - begin);
    const absl::StatusOr<const char*> block = blocks->Next(begin, count);
    if (!block.ok()) return block.status();
    const char* const records = *block;
    for (size_t axis = 0; axis < 3; ++axis) {
      AppendCoordinates(header.frame.axes[axis], records + axis * sizeof(int32_t), count, header.record_bytes,
                        coordinates[axis]);
    }
    for (LasColumnReader& reader : readers) reader.Append(records, count, header.record_bytes);
  }
  static constexpr const char* kAxes[] = {"x", "y", "z"};
  for (size_t axis = 0; axis < 3; ++axis) table.Set({kAxes[axis], std::move(coordinates[axis])});
  for (LasColumnReader& reader : readers) {
    for (Column& column : reader.Finish()) table.Set(std::move(column));
  }
  return absl::OkStatus();
}

// Whether the file says that x and y are longitude and latitude: by the GeoTIFF key GTModelType, or the first word of
// the well-known text.
bool IsGeographic(const LasFrame& frame) {
  constexpr uint16_t kGeoKeys = 34735, kWellKnownText = 2112, kModelType = 1024, kGeographic = 2;
  for (const LasRecord& record : frame.records) {
    const std::string_view payload = record.payload;
    if (record.Is("LASF_Projection", kWellKnownText)) {
      const absl::string_view text = absl::StripLeadingAsciiWhitespace({payload.data(), payload.size()});
      for (const char* word : {"GEOGCS", "GEOGCRS", "GEOGRAPHICCRS"}) {
        if (absl::StartsWithIgnoreCase(text, word)) return true;
      }
    } else if (record.Is("LASF_Projection", kGeoKeys)) {
      // Keys of four numbers each, behind a header of four; the last is the value.
      for (size_t at = 8; at + 8 <= payload.size(); at += 8) {
        if (ScalarAt<uint16_t>(payload, at) == kModelType && ScalarAt<uint16_t>(payload, at + 6) == kGeographic) {
          return true;
        }
      }
    }
  }
  return false;
}

void AddNotes(std::string_view file, const LasHeader& header, PointTable& table) {
  const Column* const withheld = table.Find("withheld");
  size_t deleted = 0;
  for (size_t i = 0; i < withheld->size(); ++i) deleted += withheld->At(i) != 0.0;
  if (deleted > 0) {
    table.notes.push_back(absl::StrCat(deleted,
                                       " points are marked as withheld, which is to say deleted: they take "
                                       "part like others"));
  }
  if (IsGeographic(header.frame)) {
    table.notes.push_back(
        "the file's coordinates are longitude and latitude: curvature needs one length unit on all axes. Project the "
        "points first, as with \"pdal translate in.las out.las reprojection\"");
  }
  for (const LasAxis& axis : header.frame.axes) {
    constexpr double kFinest = 9'007'199'254'740'992.0;  // 2^53
    if (std::abs(axis.offset) / axis.scale < kFinest) continue;
    table.notes.push_back(absl::StrCat("coordinates are rounded: an offset of ", axis.offset,
                                       " with a scale factor of ", axis.scale, " takes more digits than a double has"));
    break;
  }
  if (header.end < file.size()) {
    table.notes.push_back(absl::StrCat("left out ", file.size() - header.end, " bytes at the end of the file"));
  }
}

}  // namespace

absl::StatusOr<PointTable> ReadLas(std::string_view bytes) {
  absl::StatusOr<LasHeader> header = ReadLasHeader(bytes);
  if (!header.ok()) return header.status();
  PointTable table;
  const size_t standard = LasRecordBytes(header->frame.point_format);
  std::set<std::string> names = StandardNames(header->frame.point_format);
  std::vector<LasExtra> extras =
      ReadDescriptors(header->extra_bytes, header->record_bytes - standard, names, table.notes);
  absl::Status status = ReadPoints(bytes, *header, AllFields(header->frame, standard, extras), table);
  if (!status.ok()) return status;
  AddNotes(bytes, *header, table);
  header->frame.extras = std::move(extras);
  table.las = std::make_shared<const LasFrame>(std::move(header->frame));
  return table;
}

}  // namespace curv
