#include "client/io/writing/rows.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <variant>
#include <vector>

#include "client/io/point_status.h"

namespace curv {
namespace {

constexpr size_t kBlockRows = 4096;
constexpr size_t kBlockBytes = 1 << 20;

// Copies rows [begin, begin + count) of `column` to every row_bytes-th place from `out`.
void Scatter(const Column& column, size_t begin, size_t count, size_t row_bytes, char* out) {
  std::visit(
      [&](const auto& values) {
        for (size_t i = 0; i < count; ++i) std::memcpy(out + i * row_bytes, &values[begin + i], sizeof(values[0]));
      },
      column.values);
}

void AppendValue(const Column& column, bool as_word, size_t row, std::string& out) {
  // Another program's status may have values that no word stands for.
  if (as_word && column.At(row) < static_cast<double>(kStatusWords.size())) {
    out.append(StatusWord(std::get<std::vector<uint8_t>>(column.values)[row]));
  } else {
    std::visit([&](const auto& values) { AppendNumber(values[row], out); }, column.values);
  }
}

std::vector<const Column*> ColumnsOfTable(const PointTable& table) {
  std::vector<const Column*> columns;
  for (const Column& column : table.columns()) columns.push_back(&column);
  return columns;
}

}  // namespace

absl::Status AppendBinaryRows(const PointTable& table, ByteSink& file) {
  return AppendBinaryColumns(ColumnsOfTable(table), file);
}

absl::Status AppendBinaryColumns(std::span<const Column* const> columns, ByteSink& file) {
  const size_t rows = columns.empty() ? 0 : columns.front()->size();
  size_t row_bytes = 0;
  for (const Column* column : columns) row_bytes += BytesOf(column->kind());
  std::string block(kBlockRows * row_bytes, '\0');
  for (size_t begin = 0; begin < rows; begin += kBlockRows) {
    const size_t count = std::min(kBlockRows, rows - begin);
    size_t offset = 0;
    for (const Column* column : columns) {
      Scatter(*column, begin, count, row_bytes, block.data() + offset);
      offset += BytesOf(column->kind());
    }
    absl::Status status = file.Append(std::string_view(block).substr(0, count * row_bytes));
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::Status AppendTextRows(const PointTable& table, char separator, bool status_words, ByteSink& file) {
  return AppendTextRows(ColumnsOfTable(table), separator, status_words, file);
}

absl::Status AppendTextRows(std::span<const Column* const> columns, char separator, bool status_words, ByteSink& file) {
  std::string block;
  const size_t rows = columns.empty() ? 0 : columns.front()->size();
  for (size_t row = 0; row < rows; ++row) {
    bool first = true;
    for (const Column* column : columns) {
      if (!first) block += separator;
      first = false;
      const bool as_word = status_words && IsStatusName(column->name) && column->kind() == ScalarKind::kUint8;
      AppendValue(*column, as_word, row, block);
    }
    block += '\n';
    if (block.size() < kBlockBytes) continue;
    if (absl::Status status = file.Append(block); !status.ok()) return status;
    block.clear();
  }
  return file.Append(block);
}

}  // namespace curv
