#include <algorithm>
#include <cstring>
#include <string>
#include <variant>

#include "absl/strings/str_cat.h"
#include "client/io/ply_header.h"
#include "client/io/point_status.h"
#include "client/io/writers.h"

namespace curv {
namespace {

constexpr size_t kBlockRows = 4096;

std::string Header(const PointTable& table) {
  std::string header = "ply\nformat binary_little_endian 1.0\ncomment made by curv\n";
  if (table.Find("status") != nullptr) {
    absl::StrAppend(&header, "comment status");
    for (size_t value = 1; value < kStatusWords.size(); ++value) {
      absl::StrAppend(&header, " ", value, "=", std::string(kStatusWords[value]));
    }
    absl::StrAppend(&header, "\n");
  }
  absl::StrAppend(&header, "element vertex ", table.size(), "\n");
  for (const Column& column : table.columns()) {
    absl::StrAppend(&header, "property ", std::string(PlyTypeName(column.kind())), " ", HeaderName(column.name), "\n");
  }
  return absl::StrCat(header, "end_header\n");
}

// Copies rows [begin, begin + count) of `column` to every row_bytes-th place from `out`.
void Scatter(const Column& column, size_t begin, size_t count, size_t row_bytes, char* out) {
  std::visit(
      [&](const auto& values) {
        for (size_t i = 0; i < count; ++i) std::memcpy(out + i * row_bytes, &values[begin + i], sizeof(values[0]));
      },
      column.values);
}

}  // namespace

std::string HeaderName(std::string_view name) {
  std::string result(name);
  for (char& c : result) {
    if (c <= ' ' || c == ',' || c == '"' || c == '\x7f') c = '_';
  }
  return result;
}

absl::Status WritePly(const PointTable& table, AtomicFile& file) {
  if (absl::Status status = file.Append(Header(table)); !status.ok()) return status;
  size_t row_bytes = 0;
  for (const Column& column : table.columns()) row_bytes += BytesOf(column.kind());
  std::string block(kBlockRows * row_bytes, '\0');
  for (size_t begin = 0; begin < table.size(); begin += kBlockRows) {
    const size_t count = std::min(kBlockRows, table.size() - begin);
    size_t offset = 0;
    for (const Column& column : table.columns()) {
      Scatter(column, begin, count, row_bytes, block.data() + offset);
      offset += BytesOf(column.kind());
    }
    absl::Status status = file.Append(std::string_view(block).substr(0, count * row_bytes));
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

}  // namespace curv
