// Reads lines, fields and numbers of text files. Nothing depends on the locale.
#pragma once

#include <charconv>
#include <cstddef>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>

#include "absl/status/status.h"
#include "client/io/point_table.h"

namespace curv {

// Walks the lines of a text; "\n", "\r\n" and, as in files of old Macs, "\r" end a line.
class LineReader {
 public:
  explicit LineReader(std::string_view text, size_t first_line = 1) : rest_(text), number_(first_line - 1) {}

  // Moves to the next line. Returns false at the end of the text.
  bool Next(std::string_view& line);
  // Returns the number of the line that Next gave, counted from 1 as editors do.
  size_t number() const { return number_; }
  // Returns what is left after that line.
  std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
  size_t number_;
  const char* feed_ = nullptr;  // the next line feed, or the end of the text; looked for once it is passed
};

// Returns whether a character separates fields: a space, tab, carriage return, vertical tab or form feed.
bool IsBlank(char c);

// Returns a text without the byte order mark that editors and spreadsheets write before UTF-8.
std::string_view WithoutByteOrderMark(std::string_view text);

// INVALID_ARGUMENT, naming the line, if it has bytes of 0: text in UTF-16 has, and looks like words or numbers
// otherwise.
absl::Status CheckEncoding(std::string_view line, size_t line_number);

// Cuts the first field off `line` and returns it; blanks separate fields. Returns an empty one at the end of the line.
std::string_view NextField(std::string_view& line);

// Parses all of `field`, which may have a leading '+' or be "nan" or "inf". Values too small for T become 0 or
// subnormal. Returns false if the field is no number, is not an integer where T is one, or does not fit into T.
template <typename T>
bool ParseNumber(std::string_view field, T& value);

// Appends the fields of `line` to `columns`, one each; a null column drops its field. INVALID_ARGUMENT naming line,
// column and field if there are more or fewer fields than columns, or one is not a number that fits its column.
// Where integers become other doubles, the names of their columns go into `rounded`, unless it is null.
absl::Status AppendRow(std::string_view line, size_t line_number, std::span<Column* const> columns,
                       std::set<std::string>* rounded = nullptr);

// Returns how many bytes the character of UTF-8 takes that `text` begins with: 1 to 4, or 0 if it begins with none, as
// with cut, overlong or stray bytes.
size_t LengthOfCharacter(std::string_view text);

// Returns text from a file as messages may show it: shortened, and with '?' for characters that a terminal could obey
// and for bytes that are not UTF-8.
std::string Printable(std::string_view text);
// The same in quotes.
std::string Quoted(std::string_view field);

namespace internal {
// Whether a number that no type can hold is too small, rather than too large.
bool IsTiny(std::string_view number);
}  // namespace internal

template <typename T>
bool ParseNumber(std::string_view field, T& value) {
  if (!field.empty() && field.front() == '+') field.remove_prefix(1);
  if (field.empty() || field.front() == '+') return false;
  const char* end = field.data() + field.size();
  const auto [stop, error] = std::from_chars(field.data(), end, value);
  if (error == std::errc() && stop == end) return true;
  if constexpr (std::is_floating_point_v<T>) {
    // from_chars reports both alike.
    if (error == std::errc::result_out_of_range && stop == end && internal::IsTiny(field)) {
      value = field.front() == '-' ? T{-0.0} : T{0.0};
      return true;
    }
  }
  return false;
}

}  // namespace curv
