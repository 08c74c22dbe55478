#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/io/names/column_names.h"
#include "client/io/writers.h"
#include "client/io/writing/rows.h"

namespace curv {
namespace {

// In the order of ScalarKind.
constexpr char kTypes[] = {'I', 'U', 'I', 'U', 'I', 'U', 'F', 'F'};

// The names that PCL gives normals.
std::string FieldName(std::string name) {
  for (const auto& [in_table, in_file] : {std::pair("nx", "normal_x"), {"ny", "normal_y"}, {"nz", "normal_z"}}) {
    if (name == in_table) return in_file;
  }
  return name;
}

// PCD 0.7, whose readers want the lines in this order.
std::string Header(const PointTable& table, uint64_t rows, const char* encoding) {
  std::string fields, sizes, types, counts;
  const std::vector<std::string> names = HeaderNames(table, HeaderName);
  for (size_t i = 0; i < names.size(); ++i) {
    const Column& column = table.columns()[i];
    absl::StrAppend(&fields, " ", FieldName(names[i]));
    absl::StrAppend(&sizes, " ", BytesOf(column.kind()));
    absl::StrAppend(&types, " ", std::string(1, kTypes[static_cast<size_t>(column.kind())]));
    absl::StrAppend(&counts, " 1");
  }
  std::string viewpoint = "0 0 0";
  if (table.viewpoint.has_value()) {
    const auto& v = *table.viewpoint;
    viewpoint.clear();
    for (size_t axis = 0; axis < v.size(); ++axis) {
      if (axis > 0) viewpoint += ' ';
      AppendNumber(v[axis], viewpoint);
    }
  }
  return absl::StrCat("# .PCD v0.7 - made by curv\nVERSION 0.7\nFIELDS", fields, "\nSIZE", sizes, "\nTYPE", types,
                      "\nCOUNT", counts, "\nWIDTH ", rows, "\nHEIGHT 1\nVIEWPOINT ", viewpoint, " 1 0 0 0\nPOINTS ",
                      rows, "\nDATA ", encoding, "\n");
}

}  // namespace

std::string PcdHead(const PointTable& like, uint64_t rows) { return Header(like, rows, "binary"); }

std::string AsciiPcdHead(const PointTable& like, uint64_t rows) { return Header(like, rows, "ascii"); }

absl::Status WritePcd(const PointTable& table, ByteSink& file) {
  if (absl::Status status = file.Append(PcdHead(table, table.size())); !status.ok()) return status;
  return AppendBinaryRows(table, file);
}

absl::Status WriteAsciiPcd(const PointTable& table, ByteSink& file) {
  if (absl::Status status = file.Append(AsciiPcdHead(table, table.size())); !status.ok()) return status;
  return AppendTextRows(table, ' ', /*status_words=*/false, file);
}

}  // namespace curv
