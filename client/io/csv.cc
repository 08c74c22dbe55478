#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "client/io/formats.h"
#include "client/io/names/column_names.h"
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

// What separates the cells of a file whose first line is `names`: commas, or what spreadsheets write in their place.
char SeparatorOf(std::string_view names) {
  for (const char separator : {',', ';', '\t'}) {
    if (names.find(separator) != std::string_view::npos) return separator;
  }
  return ',';
}

// Walks the cells of a line. A separator between quotes separates cells as any other.
class Cells {
 public:
  Cells(std::string_view line, char separator) : line_(line), separator_(separator) {}

  // Moves to the next cell. Returns false if the line had none left.
  bool Next(std::string_view& cell) {
    if (at_end_) return false;
    const size_t end = line_.find(separator_);
    cell = Unquoted(Trimmed(line_.substr(0, end)));
    at_end_ = end == std::string_view::npos;
    line_.remove_prefix(at_end_ ? line_.size() : end + 1);
    return true;
  }

 private:
  std::string_view line_;
  const char separator_;
  bool at_end_ = false;
};

absl::Status ErrorAt(size_t line, const std::string& problem) {
  return absl::InvalidArgumentError(absl::StrCat("line ", line, ": ", problem));
}

absl::StatusOr<std::vector<Column>> ReadNames(Cells cells) {
  std::vector<std::string> spellings;
  for (std::string_view cell; cells.Next(cell);) {
    if (spellings.size() == kMaxColumns) return ErrorAt(1, absl::StrCat("more than ", kMaxColumns, " columns"));
    if (cell.empty()) return ErrorAt(1, absl::StrCat("column ", spellings.size() + 1, " has no name"));
    spellings.emplace_back(cell);
  }
  absl::StatusOr<std::vector<std::string>> names = TableNames(spellings, "columns");
  if (!names.ok()) return ErrorAt(1, std::string(names.status().message()));
  std::vector<Column> columns;
  for (std::string& name : *names) {
    const ScalarKind kind = IsStatusName(name) ? ScalarKind::kUint8 : ScalarKind::kFloat64;
    columns.push_back({std::move(name), MakeValues(kind)});
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

std::string Expected(ScalarKind kind, std::string_view cell) {
  if (kind == ScalarKind::kUint8) return "a status word, or its number";
  return cell.find(',') != std::string_view::npos ? "a number with a point, not a comma" : "a number";
}

absl::Status AppendCells(Cells cells, size_t number, std::vector<Column>& columns) {
  size_t count = 0;
  for (std::string_view cell; cells.Next(cell); ++count) {
    if (count < columns.size() && !AppendCell(cell, columns[count])) {
      return ErrorAt(number, absl::StrCat("value ", count + 1, " (", Printable(columns[count].name), ") is ",
                                          Quoted(cell), ": expected ", Expected(columns[count].kind(), cell)));
    }
  }
  if (count == columns.size()) return absl::OkStatus();
  return ErrorAt(number, absl::StrCat("expected ", columns.size(), " values, found ", count));
}

}  // namespace

absl::StatusOr<PointTable> ReadCsv(std::string_view bytes) {
  LineReader lines(bytes);
  std::string_view line;
  if (!lines.Next(line)) return ErrorAt(1, "the file is empty: expected a line with the columns' names");
  line = WithoutByteOrderMark(line);
  const char separator = SeparatorOf(line);
  absl::StatusOr<std::vector<Column>> columns = ReadNames({line, separator});
  if (!columns.ok()) return columns.status();
  while (lines.Next(line)) {
    if (Trimmed(line).empty()) continue;
    if (absl::Status status = AppendCells({line, separator}, lines.number(), *columns); !status.ok()) return status;
  }
  PointTable table;
  for (Column& column : *columns) table.Set(std::move(column));
  return table;
}

}  // namespace curv
