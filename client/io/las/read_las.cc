#include <algorithm>
#include <cstring>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/io/formats.h"
#include "client/io/las/las_columns.h"
#include "client/io/las/las_layout.h"
#include "client/io/las/laz_points.h"

namespace curv {
namespace {

// Rows that are taken apart at a time, so that they are read from memory once.
constexpr size_t kBlockRows = 4096;

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

void AddNotes(std::string_view file, const LasHeader& header, PointTable& table) {
  const Column* const withheld = table.Find("withheld");
  size_t deleted = 0;
  for (size_t i = 0; i < withheld->size(); ++i) deleted += withheld->At(i) != 0.0;
  if (deleted > 0) table.notes.push_back(absl::StrCat(deleted, kWithheldNote));
  if (header.end < file.size()) {
    table.notes.push_back(absl::StrCat("left out ", file.size() - header.end, " bytes at the end of the file"));
  }
}

}  // namespace

absl::StatusOr<PointTable> ReadLas(std::string_view bytes) {
  absl::StatusOr<LasLayout> layout = ReadLasLayout(bytes);
  if (!layout.ok()) return layout.status();
  PointTable table;
  table.notes = std::move(layout->notes);
  if (absl::Status status = ReadPoints(bytes, layout->header, layout->fields, table); !status.ok()) return status;
  AddNotes(bytes, layout->header, table);
  layout->header.frame.extras = std::move(layout->extras);
  table.las = std::make_shared<const LasFrame>(std::move(layout->header.frame));
  return table;
}

}  // namespace curv
