#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "client/io/formats.h"
#include "client/io/long_integers.h"
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

// What separates the cells of a file whose first line is `names`: commas, or what spreadsheets write in their place.
// Names in quotes may hold any of them.
char SeparatorOf(std::string_view names) {
  for (const char separator : {',', ';', '\t'}) {
    bool in_quotes = false;
    for (const char c : names) {
      if (c == '"') in_quotes = !in_quotes;
      if (c == separator && !in_quotes) return separator;
    }
  }
  return ',';
}

// Walks the cells of a line. One in quotes may hold separators, and quotes as two.
class Cells {
 public:
  Cells(std::string_view line, char separator) : line_(line), separator_(separator) {}

  // Moves to the next cell, without the quotes around it, which many programs write around names, and some around
  // values. Returns false if the line had none left.
  bool Next(std::string_view& cell) {
    if (at_end_) return false;
    size_t end = QuotedEnd();
    was_quoted_ = end != std::string_view::npos;
    if (!was_quoted_) end = line_.find(separator_);
    cell = Trimmed(line_.substr(0, end));
    at_end_ = end >= line_.size();
    line_.remove_prefix(at_end_ ? line_.size() : end + 1);
    if (was_quoted_) cell = Trimmed(cell.substr(1, cell.size() - 2));
    return true;
  }

  bool was_quoted() const { return was_quoted_; }

 private:
  // Where a cell in quotes ends, its separator or the end of the line; npos if it is not in quotes.
  size_t QuotedEnd() const {
    size_t at = 0;
    while (at < line_.size() && IsBlank(line_[at]) && line_[at] != separator_) ++at;
    if (at == line_.size() || line_[at] != '"') return std::string_view::npos;
    for (at = line_.find('"', at + 1); at != std::string_view::npos; at = line_.find('"', at + 1)) {
      size_t next = at + 1;
      if (next < line_.size() && line_[next] == '"') {
        at = next;
        continue;
      }
      while (next < line_.size() && IsBlank(line_[next]) && line_[next] != separator_) ++next;
      if (next == line_.size() || line_[next] == separator_) return next;
    }
    return std::string_view::npos;
  }

  std::string_view line_;
  const char separator_;
  bool at_end_ = false;
  bool was_quoted_ = false;
};

absl::Status ErrorAt(size_t line, const std::string& problem) {
  return absl::InvalidArgumentError(absl::StrCat("line ", line, ": ", problem));
}

struct CsvColumn {
  Column column;
  bool may_lack = true;     // whether an empty cell is NaN: not in positions and normals
  bool has_number = false;  // so far
  bool is_words = false;    // which are left out
  bool is_rounded = false;  // whether an integer became another double
};

struct CsvColumns {
  std::vector<CsvColumn> columns;
  bool has_end = false;  // whether the line of names ends with a separator, so that other lines may
};

bool IsNumber(std::string_view cell) {
  double value;
  return ParseNumber(cell, value);
}

// A first column without a name is that of the rows' names, as pandas and R write it.
std::string IndexName(const std::vector<std::string>& others) {
  std::string name = "index";
  for (int number = 2; std::find(others.begin(), others.end(), name) != others.end(); ++number) {
    name = absl::StrCat("index_", number);
  }
  return name;
}

absl::StatusOr<CsvColumns> ReadNames(Cells cells) {
  CsvColumns result;
  std::vector<std::string> spellings;
  for (std::string_view cell; cells.Next(cell);) {
    spellings.push_back(absl::StrReplaceAll(std::string(cell), {{"\"\"", "\""}}));
    if (spellings.size() > kMaxColumns + 1) break;
  }
  if (spellings.size() > 1 && spellings.back().empty() && !cells.was_quoted()) {
    spellings.pop_back();
    result.has_end = true;
  }
  if (spellings.size() > kMaxColumns) return ErrorAt(1, absl::StrCat("more than ", kMaxColumns, " columns"));
  if (std::all_of(spellings.begin(), spellings.end(), IsNumber)) {
    return ErrorAt(
        1, "expected the columns' names, found numbers: write x,y,z, and a name for each further column, before it");
  }
  if (spellings.size() > 1 && spellings.front().empty()) spellings.front() = IndexName(spellings);
  const auto nameless = std::find(spellings.begin(), spellings.end(), "");
  if (nameless != spellings.end()) {
    return ErrorAt(1, absl::StrCat("column ", nameless - spellings.begin() + 1, " has no name"));
  }
  absl::StatusOr<std::vector<std::string>> names = TableNames(spellings, "columns");
  if (!names.ok()) return ErrorAt(1, std::string(names.status().message()));
  for (std::string& name : *names) {
    const bool is_vector = name == "x" || name == "y" || name == "z" || name == "nx" || name == "ny" || name == "nz";
    const ScalarKind kind = IsStatusName(name) ? ScalarKind::kUint8 : ScalarKind::kFloat64;
    result.columns.push_back({.column = {std::move(name), MakeValues(kind)}, .may_lack = !is_vector});
  }
  return result;
}

// Whether a cell that is no number was not meant as one: it has more than digits, and points or commas between them.
bool IsWord(std::string_view cell) {
  if (cell.starts_with('-') || cell.starts_with('+')) cell.remove_prefix(1);
  if (cell.find_first_not_of("0123456789.,; \t") == std::string_view::npos) return false;
  // Of digits with an exponent, no double has the number.
  return cell.find_first_not_of("0123456789.,; \teE+-") != std::string_view::npos ||
         cell.find_first_of("eE") == std::string_view::npos;
}

// Other programs' statuses may be any numbers.
bool AppendStatus(std::string_view cell, Column& column) {
  const std::optional<uint8_t> known = StatusOfWord(cell);
  if (auto* bytes = std::get_if<std::vector<uint8_t>>(&column.values)) {
    uint8_t byte = known.value_or(0);
    if (known.has_value() || ParseNumber(cell, byte)) {
      bytes->push_back(byte);
      return true;
    }
    double value;
    if (!cell.empty() && !ParseNumber(cell, value)) return false;
    column.values = std::vector<double>(bytes->begin(), bytes->end());
  }
  double value = known.has_value() ? *known : std::numeric_limits<double>::quiet_NaN();
  if (!known.has_value() && !cell.empty() && !ParseNumber(cell, value)) return false;
  std::get<std::vector<double>>(column.values).push_back(value);
  return true;
}

bool AppendCell(std::string_view cell, CsvColumn& target) {
  if (target.is_words) return true;
  if (IsStatusName(target.column.name)) return AppendStatus(cell, target.column);
  auto& values = std::get<std::vector<double>>(target.column.values);
  double value = std::numeric_limits<double>::quiet_NaN();
  if (ParseNumber(cell, value)) {
    target.has_number = true;
    target.is_rounded = target.is_rounded || IsRounded(cell, value);
  } else if (!target.may_lack) {
    return false;
  } else if (!cell.empty()) {
    target.is_words = !target.has_number && IsWord(cell);
    return target.is_words;
  }
  values.push_back(value);
  return true;
}

std::string Expected(const CsvColumn& target, std::string_view cell) {
  if (IsStatusName(target.column.name)) return "a status word, or a number";
  return cell.find(',') != std::string_view::npos ? "a number with a point, not a comma" : "a number";
}

absl::Status AppendCells(Cells cells, size_t number, CsvColumns& target) {
  std::vector<CsvColumn>& columns = target.columns;
  size_t count = 0;
  for (std::string_view cell; cells.Next(cell); ++count) {
    if (count == columns.size() && target.has_end && !cell.empty()) {
      return ErrorAt(number, absl::StrCat("value ", count + 1, " is ", Quoted(cell), ": its column has no name"));
    }
    if (count < columns.size() && !AppendCell(cell, columns[count])) {
      return ErrorAt(number, absl::StrCat("value ", count + 1, " (", Printable(columns[count].column.name), ") is ",
                                          Quoted(cell), ": expected ", Expected(columns[count], cell)));
    }
  }
  if (count == columns.size() || (count == columns.size() + 1 && target.has_end)) return absl::OkStatus();
  return ErrorAt(
      number, absl::StrCat("expected ", columns.size(), columns.size() == 1 ? " value" : " values", ", found ", count));
}

// The line of names, as some programs write it, which make it a comment.
std::string_view WithoutCommentMark(std::string_view line) {
  const std::string_view trimmed = Trimmed(line);
  if (!trimmed.starts_with('#') && !trimmed.starts_with("//")) return line;
  return Trimmed(trimmed.substr(std::min(trimmed.find_first_not_of("#/"), trimmed.size())));
}

}  // namespace

absl::StatusOr<PointTable> ReadCsv(std::string_view bytes) {
  LineReader lines(bytes);
  std::string_view names;
  if (!lines.Next(names)) return ErrorAt(1, "the file is empty: expected a line with the columns' names");
  LinesBefore before{.count = 1, .words = {}};
  return ReadCsvBlock(names, lines.rest(), before);
}

absl::StatusOr<PointTable> ReadCsvBlock(std::string_view start, std::string_view text, LinesBefore& before) {
  if (absl::Status status = CheckEncoding(start, 1); !status.ok()) return status;
  start = WithoutCommentMark(WithoutByteOrderMark(start));
  const char separator = SeparatorOf(start);
  absl::StatusOr<CsvColumns> columns = ReadNames({start, separator});
  if (!columns.ok()) return columns.status();
  for (CsvColumn& target : columns->columns) target.is_words = before.words.contains(target.column.name);
  LineReader lines(text, before.count + 1);
  for (std::string_view line; lines.Next(line);) {
    if (Trimmed(line).empty()) continue;
    if (absl::Status status = AppendCells({line, separator}, lines.number(), *columns); !status.ok()) return status;
  }
  before.count = lines.number();
  PointTable table;
  for (CsvColumn& target : columns->columns) {
    if (target.is_words) {
      before.words.insert(target.column.name);
      table.notes.push_back(absl::StrCat("left out column ", Printable(target.column.name), ": it holds words"));
    } else {
      if (target.is_rounded) NoteRounded({target.column.name}, table.notes);
      table.Set(std::move(target.column));
    }
  }
  return table;
}

}  // namespace curv
