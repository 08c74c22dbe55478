#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "client/io/formats.h"
#include "client/io/point_status.h"
#include "client/io/text.h"

namespace curv {
namespace {

std::string_view Trimmed(std::string_view field) {
  while (!field.empty() && IsBlank(field.front())) field.remove_prefix(1);
  while (!field.empty() && IsBlank(field.back())) field.remove_suffix(1);
  return field;
}

// Without the quotes around it, which many programs write around names, and some around values.
std::string_view Unquoted(std::string_view cell) {
  if (cell.size() < 2 || cell.front() != '"' || cell.back() != '"') return cell;
  return Trimmed(cell.substr(1, cell.size() - 2));
}

// Cuts the first field off; false if the line had none left. A comma between quotes separates cells as any other.
bool NextCell(std::string_view& line, bool& at_end, std::string_view& cell) {
  if (at_end) return false;
  const size_t comma = line.find(',');
  cell = Unquoted(Trimmed(line.substr(0, comma)));
  at_end = comma == std::string_view::npos;
  line.remove_prefix(at_end ? line.size() : comma + 1);
  return true;
}

absl::Status ErrorAt(size_t line, const std::string& problem) {
  return absl::InvalidArgumentError(absl::StrCat("line ", line, ": ", problem));
}

// The name of a column: that of a coordinate in lower case, as some programs write it in upper case.
std::string ColumnName(std::string_view name) {
  const std::string lower = absl::AsciiStrToLower(std::string(name));
  for (const char* known : {"x", "y", "z", "nx", "ny", "nz"}) {
    if (lower == known) return lower;
  }
  return std::string(name);
}

absl::StatusOr<std::vector<Column>> ReadNames(std::string_view line) {
  line = WithoutByteOrderMark(line);
  std::vector<Column> columns;
  bool at_end = false;
  for (std::string_view cell; NextCell(line, at_end, cell);) {
    const std::string name = ColumnName(cell);
    if (columns.size() == kMaxColumns) return ErrorAt(1, absl::StrCat("more than ", kMaxColumns, " columns"));
    if (name.empty()) return ErrorAt(1, absl::StrCat("column ", columns.size() + 1, " has no name"));
    for (const Column& other : columns) {
      if (other.name == name) return ErrorAt(1, absl::StrCat("two columns have the name ", Quoted(name)));
    }
    columns.push_back({name, MakeValues(IsStatusName(name) ? ScalarKind::kUint8 : ScalarKind::kFloat64)});
  }
  return columns;
}

bool AppendCell(std::string_view cell, Column& column) {
  if (column.kind() == ScalarKind::kUint8) {
    std::optional<uint8_t> value = StatusOfWord(cell);
    if (uint32_t number; !value && ParseNumber(cell, number) && number <= 255) value = static_cast<uint8_t>(number);
    if (value) std::get<std::vector<uint8_t>>(column.values).push_back(*value);
    return value.has_value();
  }
  double value;
  if (!ParseNumber(cell, value)) return false;
  std::get<std::vector<double>>(column.values).push_back(value);
  return true;
}

absl::Status AppendCells(std::string_view line, size_t number, std::vector<Column>& columns) {
  size_t cells = 0;
  bool at_end = false;
  for (std::string_view cell; NextCell(line, at_end, cell); ++cells) {
    if (cells < columns.size() && !AppendCell(cell, columns[cells])) {
      return ErrorAt(
          number, absl::StrCat("value ", cells + 1, " (", Printable(columns[cells].name), ") is ", Quoted(cell),
                               columns[cells].kind() == ScalarKind::kUint8 ? ": expected a status word, or its number"
                                                                           : ": expected a number"));
    }
  }
  if (cells == columns.size()) return absl::OkStatus();
  return ErrorAt(number, absl::StrCat("expected ", columns.size(), " values, found ", cells));
}

}  // namespace

absl::StatusOr<PointTable> ReadCsv(std::string_view bytes) {
  LineReader lines(bytes);
  std::string_view line;
  if (!lines.Next(line)) return ErrorAt(1, "the file is empty: expected a line with the columns' names");
  absl::StatusOr<std::vector<Column>> columns = ReadNames(line);
  if (!columns.ok()) return columns.status();
  while (lines.Next(line)) {
    if (Trimmed(line).empty()) continue;
    if (absl::Status status = AppendCells(line, lines.number(), *columns); !status.ok()) return status;
  }
  PointTable table;
  for (Column& column : *columns) table.Set(std::move(column));
  return table;
}

}  // namespace curv
