#include <algorithm>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "client/io/formats.h"
#include "client/io/long_integers.h"
#include "client/io/names/column_names.h"
#include "client/io/names/columns_by_place.h"
#include "client/io/text.h"

namespace curv {
namespace {

// A longer one names no columns: there are at most kMaxColumns.
constexpr size_t kMaxComment = 1 << 20;

bool IsSeparator(char c) { return c == ',' || c == ';'; }

// A line with its commas and semicolons, if any, made blanks.
std::string_view WithBlanks(std::string_view line, std::string& scratch) {
  if (line.find_first_of(",;") == std::string_view::npos) return line;
  scratch.assign(line);
  for (char& c : scratch) {
    if (IsSeparator(c)) c = ' ';
  }
  return scratch;
}

// Where a line, which has values, has an empty cell: before a separator without a value of its own. What follows the
// last separator may be empty.
std::optional<size_t> FindEmptyCell(std::string_view line) {
  size_t values = 0;
  bool in_value = false, is_empty = true;
  for (const char c : line) {
    if (IsSeparator(c)) {
      if (is_empty) return values;
      is_empty = true;
      in_value = false;
    } else if (IsBlank(c)) {
      in_value = false;
    } else if (!in_value) {
      in_value = true;
      is_empty = false;
      ++values;
    }
  }
  return std::nullopt;
}

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

// Whether the commas of a line seem to be decimal ones, as in "0,25 1,5 3": other characters separate its values, and
// each comma is the only one of its value and stands between digits.
bool SeemsToHaveDecimalCommas(std::string_view line) {
  size_t commas = 0, values = 0;
  bool has_comma = false, in_value = false;
  for (size_t i = 0; i < line.size(); ++i) {
    if (IsBlank(line[i]) || line[i] == ';') {
      in_value = has_comma = false;
      continue;
    }
    if (!in_value) ++values;
    in_value = true;
    if (line[i] != ',') continue;
    if (has_comma || i == 0 || i + 1 == line.size() || !IsDigit(line[i - 1]) || !IsDigit(line[i + 1])) return false;
    has_comma = true;
    ++commas;
  }
  return commas > 0 && values > 1;
}

bool IsSkipped(std::string_view line) {
  const std::string_view first = NextField(line);
  return first.empty() || first.front() == '#' || first.substr(0, 2) == "//";
}

size_t CountFields(std::string_view line) {
  size_t count = 0;
  while (!NextField(line).empty()) ++count;
  return count;
}

// Whether no field of a line is a number, as in a line of names.
bool HoldsNoNumber(std::string_view line) {
  for (std::string_view field; !(field = NextField(line)).empty();) {
    if (double value; ParseNumber(field, value)) return false;
  }
  return true;
}

// The columns' names in a comment, if it starts with x y z and has a word for each of `count` columns. INVALID_ARGUMENT
// where x y z come later: it may be a header, by which other columns were the coordinates, or prose.
absl::StatusOr<std::vector<std::string>> NamesIn(std::string_view comment, size_t count) {
  const std::string_view whole = comment;
  comment.remove_prefix(std::min(comment.find_first_not_of(" \t#/"), comment.size()));
  std::vector<std::string> names;
  while (names.size() <= count) {
    std::string name = TableName(NextField(comment));
    if (name.empty()) break;
    if (std::find(names.begin(), names.end(), name) != names.end()) return std::vector<std::string>();
    names.push_back(std::move(name));
  }
  if (names.size() != count) return std::vector<std::string>();
  if (names[0] == "x" && names[1] == "y" && names[2] == "z") return names;
  for (const char* axis : {"x", "y", "z"}) {
    if (std::find(names.begin(), names.end(), axis) == names.end()) return std::vector<std::string>();
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "the comment ", Quoted(whole), " has a word for each column, x, y and z among them, but does not ",
      "begin with x y z: move those columns to the front, write the names as the first line of a .csv, or ",
      "leave the comment out if the first columns are x y z"));
}

std::vector<Column> MakeColumns(const std::vector<std::string>& names) {
  std::vector<Column> columns;
  columns.reserve(names.size());
  for (const std::string& name : names) columns.push_back({name, std::vector<double>()});
  return columns;
}

std::vector<Column> MakeColumns(size_t count) {
  static constexpr const char* kNames[] = {"x", "y", "z", "nx", "ny", "nz"};
  std::vector<Column> columns;
  for (size_t i = 0; i < count; ++i) {
    columns.push_back(
        {i < 6 && (i < 3 || count >= 6) ? kNames[i] : absl::StrCat("column", i + 1), std::vector<double>()});
  }
  return columns;
}

// The columns, or, before there are any, those of a line without names.
absl::Status EmptyCellError(size_t line, size_t cell, const std::vector<Column>& columns) {
  std::string name;
  if (columns.empty()) {
    name = absl::StrCat(" (", cell < 3 ? std::string(1, "xyz"[cell]) : absl::StrCat("column", cell + 1), ")");
  } else if (cell < columns.size()) {
    name = absl::StrCat(" (", Printable(columns[cell].name), ")");
  }
  return absl::InvalidArgumentError(
      absl::StrCat("line ", line, ": value ", cell + 1, name, " is \"\": expected a number"));
}

}  // namespace

absl::StatusOr<PointTable> ReadXyz(std::string_view bytes) {
  LinesBefore before;
  return ReadXyzBlock("", WithoutByteOrderMark(bytes), before);
}

absl::StatusOr<PointTable> ReadXyzBlock(std::string_view start, std::string_view text, LinesBefore& before) {
  LineReader lines(text, before.count + 1);
  std::string scratch;
  std::vector<Column> columns;
  std::vector<Column*> targets;
  std::set<std::string> rounded;
  std::optional<uint64_t> declared;
  size_t rows = 0;
  std::string comment(WithBlanks(start, scratch));
  bool named = false;
  for (std::string_view raw; lines.Next(raw);) {
    const std::string_view line = WithBlanks(raw, scratch);
    if (IsSkipped(line)) {
      if (columns.empty() && line.size() <= kMaxComment) comment = line;
      continue;
    }
    if (columns.empty()) {
      if (absl::Status status = CheckEncoding(raw, lines.number()); !status.ok()) return status;
    }
    if (SeemsToHaveDecimalCommas(raw)) {
      return absl::InvalidArgumentError(
          absl::StrCat("line ", lines.number(), ": ", Quoted(raw),
                       " seems to have decimal commas: write points for them, or the same "
                       "separator between all values"));
    }
    if (const std::optional<size_t> cell = FindEmptyCell(raw); cell.has_value()) {
      return EmptyCellError(lines.number(), *cell, columns);
    }
    if (columns.empty()) {
      const size_t count = CountFields(line);
      std::string_view rest = line;
      uint64_t value;
      if (count == 1 && !declared && ParseNumber(NextField(rest), value)) {
        declared = value;
        continue;
      }
      if (count < 3) {
        return absl::InvalidArgumentError(absl::StrCat("line ", lines.number(), ": expected x y z nx ny nz, found ",
                                                       count, count == 1 ? " value: " : " values: ", Quoted(raw)));
      }
      if (HoldsNoNumber(line)) {
        return absl::InvalidArgumentError(
            absl::StrCat("line ", lines.number(), ": ", Quoted(raw), " looks like a line of names: put # before it"));
      }
      if (count > kMaxColumns) {
        return absl::InvalidArgumentError(
            absl::StrCat("line ", lines.number(), ": found ", count, " values: expected at most ", kMaxColumns));
      }
      const absl::StatusOr<std::vector<std::string>> names = NamesIn(comment, count);
      if (!names.ok()) return names.status();
      named = !names->empty();
      columns = named ? MakeColumns(*names) : MakeColumns(count);
      for (Column& column : columns) targets.push_back(&column);
    }
    if (absl::Status status = AppendRow(line, lines.number(), targets, &rounded); !status.ok()) return status;
    ++rows;
  }
  before.count = lines.number();
  if (declared && *declared != rows) {
    return absl::InvalidArgumentError(absl::StrCat("line ", lines.number(), ": the first line declares ", *declared,
                                                   " points, the file holds ", rows));
  }
  if (columns.empty()) columns = MakeColumns(6);
  PointTable table;
  NoteRounded(rounded, table.notes);
  if (!named) {
    NameByPlace(NoVectors::kAreNone,
                "put the line \"# x y z nx ny nz\" before the points, with a name for each further column", columns,
                table.notes);
  }
  for (Column& column : columns) table.Set(std::move(column));
  return table;
}

}  // namespace curv
