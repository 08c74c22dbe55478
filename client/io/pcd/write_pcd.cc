#include <algorithm>
#include <array>
#include <span>
#include <string>

#include "absl/strings/str_cat.h"
#include "client/io/pcd/packed_colors.h"
#include "client/io/writers.h"
#include "client/io/writing/rows.h"

namespace curv {
namespace {

std::string Numbers(std::span<const double> numbers) {
  std::string text;
  for (const double number : numbers) {
    text += ' ';
    AppendNumber(number, text);
  }
  return text;
}

// PCD 0.7, whose readers want the lines in this order.
std::string Header(const PointTable& table, uint64_t rows, const char* encoding, bool is_text) {
  std::string fields, sizes, types, counts;
  for (const PcdField& field : FieldsOf(table, is_text).fields) {
    absl::StrAppend(&fields, " ", field.name);
    absl::StrAppend(&sizes, " ", field.bytes);
    absl::StrAppend(&types, " ", std::string(1, field.type));
    absl::StrAppend(&counts, " 1");
  }
  const PcdFrame& frame = table.pcd;
  const bool is_organized = frame.height > 1 && frame.width == rows / frame.height && rows % frame.height == 0;
  return absl::StrCat("# .PCD v0.7 - made by curv\nVERSION 0.7\nFIELDS", fields, "\nSIZE", sizes, "\nTYPE", types,
                      "\nCOUNT", counts, "\nWIDTH ", is_organized ? frame.width : rows, "\nHEIGHT ",
                      is_organized ? frame.height : 1, "\nVIEWPOINT",
                      Numbers(table.viewpoint.value_or(std::array<double, 3>{})), Numbers(frame.rotation), "\nPOINTS ",
                      rows, "\nDATA ", encoding, "\n");
}

}  // namespace

std::string PcdHead(const PointTable& like, uint64_t rows) { return Header(like, rows, "binary", /*is_text=*/false); }

std::string AsciiPcdHead(const PointTable& like, uint64_t rows) {
  return Header(like, rows, "ascii", /*is_text=*/true);
}

absl::Status AppendPcdRows(const PointTable& table, ByteSink& file) {
  return AppendBinaryColumns(FieldsOf(table, /*is_text=*/false).columns, file);
}

absl::Status AppendAsciiPcdRows(const PointTable& table, ByteSink& file) {
  return AppendTextRows(FieldsOf(table, /*is_text=*/true).columns, ' ', /*status_words=*/false, file);
}

absl::Status WritePcd(const PointTable& table, ByteSink& file) {
  if (absl::Status status = file.Append(PcdHead(table, table.size())); !status.ok()) return status;
  return AppendPcdRows(table, file);
}

absl::Status WriteAsciiPcd(const PointTable& table, ByteSink& file) {
  if (absl::Status status = file.Append(AsciiPcdHead(table, table.size())); !status.ok()) return status;
  return AppendAsciiPcdRows(table, file);
}

}  // namespace curv
