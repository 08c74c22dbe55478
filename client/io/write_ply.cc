#include <string>

#include "absl/strings/str_cat.h"
#include "client/io/ply_header.h"
#include "client/io/point_status.h"
#include "client/io/writers.h"
#include "client/io/writing/rows.h"

namespace curv {
namespace {

std::string Header(const PointTable& table, uint64_t rows, const char* format) {
  std::string header = absl::StrCat("ply\nformat ", format, " 1.0\ncomment made by curv\n");
  if (table.Find("status") != nullptr) {
    absl::StrAppend(&header, "comment status");
    for (size_t value = 1; value < kStatusWords.size(); ++value) {
      absl::StrAppend(&header, " ", value, "=", std::string(kStatusWords[value]));
    }
    absl::StrAppend(&header, "\n");
  }
  absl::StrAppend(&header, "element vertex ", rows, "\n");
  for (const Column& column : table.columns()) {
    absl::StrAppend(&header, "property ", std::string(PlyTypeName(column.kind())), " ", HeaderName(column.name), "\n");
  }
  return absl::StrCat(header, "end_header\n");
}

}  // namespace

std::string HeaderName(std::string_view name) {
  std::string result(name);
  for (char& c : result) {
    if (c <= ' ' || c == ',' || c == '"' || c == '\x7f') c = '_';
  }
  return result;
}

std::string PlyHead(const PointTable& like, uint64_t rows) { return Header(like, rows, "binary_little_endian"); }

std::string AsciiPlyHead(const PointTable& like, uint64_t rows) { return Header(like, rows, "ascii"); }

absl::Status WritePly(const PointTable& table, ByteSink& file) {
  if (absl::Status status = file.Append(PlyHead(table, table.size())); !status.ok()) return status;
  return AppendBinaryRows(table, file);
}

absl::Status WriteAsciiPly(const PointTable& table, ByteSink& file) {
  if (absl::Status status = file.Append(AsciiPlyHead(table, table.size())); !status.ok()) return status;
  return AppendTextRows(table, ' ', /*status_words=*/false, file);
}

}  // namespace curv
