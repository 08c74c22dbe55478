#include <algorithm>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/io/names/column_names.h"
#include "client/io/ply_header.h"
#include "client/io/point_status.h"
#include "client/io/writers.h"
#include "client/io/writing/rows.h"

namespace curv {
namespace {

// Returns what programs call a column that is not a value of its own, but a part of a point.
bool IsPartOfPoint(const std::string& name) {
  constexpr std::string_view kParts[] = {"x", "y", "z", "nx", "ny", "nz", "red", "green", "blue", "alpha"};
  return std::find(std::begin(kParts), std::end(kParts), name) != std::end(kParts);
}

// `column` is one of the names that all columns have in a header.
std::string PropertyName(const PointTable& table, const std::string& column, PlyNames names) {
  if (names == PlyNames::kCloudCompare && !IsPartOfPoint(column)) return std::string(kScalarPrefix) + column;
  const bool is_quality = column == "mean_curvature" && table.Find("quality") == nullptr;
  return names == PlyNames::kMeshLab && is_quality ? "quality" : column;
}

}  // namespace

std::string PlyHead(const PointTable& table, uint64_t rows, const PlyForm& form) {
  const char* const format = form.ascii ? "ascii" : "binary_little_endian";
  std::string header = absl::StrCat("ply\nformat ", format, " 1.0\ncomment made by curv\n");
  if (table.Find("status") != nullptr) {
    absl::StrAppend(&header, "comment status");
    for (size_t value = 1; value < kStatusWords.size(); ++value) {
      absl::StrAppend(&header, " ", value, "=", std::string(kStatusWords[value]));
    }
    absl::StrAppend(&header, "\n");
  }
  absl::StrAppend(&header, "element vertex ", rows, "\n");
  const std::vector<std::string> names = HeaderNames(table, HeaderName);
  for (size_t i = 0; i < names.size(); ++i) {
    absl::StrAppend(&header, "property ", std::string(PlyTypeName(table.columns()[i].kind())), " ",
                    PropertyName(table, names[i], form.names), "\n");
  }
  return absl::StrCat(header, "end_header\n");
}

std::string HeaderName(std::string_view name) {
  std::string result(name);
  for (char& c : result) {
    // Bytes from 0x80 on are of letters in UTF-8.
    if (static_cast<unsigned char>(c) <= ' ' || c == ',' || c == ';' || c == '"' || c == '\x7f') c = '_';
  }
  return result;
}

absl::Status WritePly(const PointTable& table, ByteSink& file, const PlyForm& form) {
  if (absl::Status status = file.Append(PlyHead(table, table.size(), form)); !status.ok()) return status;
  return form.ascii ? AppendTextRows(table, ' ', /*status_words=*/false, file) : AppendBinaryRows(table, file);
}

}  // namespace curv
