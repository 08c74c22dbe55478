#include "client/io/text.h"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <variant>

#include "absl/strings/str_cat.h"
#include "client/io/long_integers.h"

namespace curv {
namespace {

absl::Status FieldError(size_t line_number, size_t index, const std::string& name, const std::string& problem) {
  return absl::InvalidArgumentError(
      absl::StrCat("line ", line_number, ": value ", index + 1, " (", Printable(name), ") ", problem));
}

absl::Status CountError(std::string_view line, size_t line_number, size_t expected) {
  size_t found = 0;
  while (!NextField(line).empty()) ++found;
  return absl::InvalidArgumentError(
      absl::StrCat("line ", line_number, ": expected ", expected, " values, found ", found));
}

// Whether a field that no float or double can hold is a number nonetheless.
bool IsTooLarge(std::string_view field) {
  if (!field.empty() && field.front() == '+') field.remove_prefix(1);
  const char* end = field.data() + field.size();
  float value;
  const auto [stop, error] = std::from_chars(field.data(), end, value);
  return error == std::errc::result_out_of_range && stop == end;
}

const char* Expectation(ScalarKind kind, std::string_view field) {
  static constexpr const char* kExpectations[] = {"an integer from -128 to 127",
                                                  "an integer from 0 to 255",
                                                  "an integer from -32768 to 32767",
                                                  "an integer from 0 to 65535",
                                                  "a 32-bit integer",
                                                  "an unsigned 32-bit integer",
                                                  "a number in the range of float",
                                                  "a number in the range of double"};
  if (kind >= ScalarKind::kFloat32 && !IsTooLarge(field)) return "a number";
  return kExpectations[static_cast<size_t>(kind)];
}

}  // namespace

namespace internal {

bool IsTiny(std::string_view number) {
  const size_t exponent_at = std::min(number.find_first_of("eE"), number.size());
  const std::string_view digits = number.substr(0, exponent_at);
  std::string_view exponent = number.substr(std::min(exponent_at + 1, number.size()));
  if (exponent.starts_with('+')) exponent.remove_prefix(1);
  int64_t power = 0;
  const std::errc error = std::from_chars(exponent.data(), exponent.data() + exponent.size(), power).ec;
  if (error == std::errc::result_out_of_range) return exponent.starts_with('-');
  // Where the leading digit stands: the power of ten that it counts.
  const size_t leading = digits.find_first_of("123456789");
  const size_t point = std::min(digits.find('.'), digits.size());
  const int64_t place = static_cast<int64_t>(point) - static_cast<int64_t>(leading) - (leading < point ? 1 : 0);
  // Their sum is far from 0, or the number would be in range; it may overflow.
  return power < -place;
}

}  // namespace internal

bool LineReader::Next(std::string_view& line) {
  if (rest_.empty()) return false;
  if (feed_ == nullptr || feed_ < rest_.data()) feed_ = rest_.data() + std::min(rest_.find('\n'), rest_.size());
  line = rest_.substr(0, static_cast<size_t>(feed_ - rest_.data()));
  line = line.substr(0, line.find('\r'));
  rest_.remove_prefix(line.size());
  // The end of the line, if it is not that of the text.
  if (rest_.starts_with("\r\n")) {
    rest_.remove_prefix(2);
  } else if (!rest_.empty()) {
    rest_.remove_prefix(1);
  }
  ++number_;
  return true;
}

std::string_view WithoutByteOrderMark(std::string_view text) {
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  if (text.substr(0, kByteOrderMark.size()) == kByteOrderMark) text.remove_prefix(kByteOrderMark.size());
  return text;
}

bool IsBlank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }

std::string_view NextField(std::string_view& line) {
  size_t begin = 0;
  while (begin < line.size() && IsBlank(line[begin])) ++begin;
  size_t end = begin;
  while (end < line.size() && !IsBlank(line[end])) ++end;
  const std::string_view field = line.substr(begin, end - begin);
  line.remove_prefix(end);
  return field;
}

absl::Status CheckEncoding(std::string_view line, size_t line_number) {
  if (line.find('\0') == std::string_view::npos) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("line ", line_number, " has bytes of 0, as text in UTF-16 has: save it as UTF-8, if it is text"));
}

absl::Status AppendRow(std::string_view line, size_t line_number, std::span<Column* const> columns,
                       std::set<std::string>* rounded) {
  std::string_view rest = line;
  for (size_t i = 0; i < columns.size(); ++i) {
    const std::string_view field = NextField(rest);
    if (field.empty()) return CountError(line, line_number, columns.size());
    if (columns[i] == nullptr) continue;
    const bool parsed = std::visit(
        [&](auto& values) {
          using Value = typename std::decay_t<decltype(values)>::value_type;
          Value value;
          if (!ParseNumber(field, value)) return false;
          values.push_back(value);
          if constexpr (std::is_same_v<Value, double>) {
            if (rounded != nullptr && IsRounded(field, value)) rounded->insert(columns[i]->name);
          }
          return true;
        },
        columns[i]->values);
    if (!parsed) {
      return FieldError(line_number, i, columns[i]->name,
                        absl::StrCat("is ", Quoted(field), ": expected ", Expectation(columns[i]->kind(), field)));
    }
  }
  if (!NextField(rest).empty()) return CountError(line, line_number, columns.size());
  return absl::OkStatus();
}

size_t LengthOfCharacter(std::string_view text) {
  if (text.empty()) return 0;
  const auto byte = static_cast<unsigned char>(text.front());
  const size_t length = byte < 0x80                   ? 1
                        : byte >= 0xc2 && byte < 0xe0 ? 2
                        : (byte & 0xf0) == 0xe0       ? 3
                        : byte >= 0xf0 && byte < 0xf5 ? 4
                                                      : 0;
  if (length > text.size()) return 0;
  uint32_t code = byte & (0x7fu >> length);
  for (size_t i = 1; i < length; ++i) {
    const auto next = static_cast<unsigned char>(text[i]);
    if ((next & 0xc0) != 0x80) return 0;
    code = code << 6 | (next & 0x3fu);
  }
  const bool is_overlong = (length == 3 && code < 0x800) || (length == 4 && code < 0x10000);
  const bool is_surrogate = code >= 0xd800 && code < 0xe000;
  return is_overlong || is_surrogate || code > 0x10ffff ? 0 : length;
}

std::string Printable(std::string_view text) {
  constexpr size_t kMaxShown = 40;
  std::string shown;
  size_t at = 0;
  while (at < text.size()) {
    const std::string_view character = text.substr(at, std::max<size_t>(LengthOfCharacter(text.substr(at)), 1));
    if (at + character.size() > kMaxShown) break;
    const bool is_ascii = character[0] >= ' ' && character[0] <= '~';
    // Below U+00A0 are control characters.
    const bool is_beyond = character.size() > 1 && character >= "\xc2\xa0";
    shown += is_ascii || is_beyond ? character : "?";
    at += character.size();
  }
  if (at < text.size()) shown += "...";
  return shown;
}

std::string Quoted(std::string_view field) { return absl::StrCat("\"", Printable(field), "\""); }

}  // namespace curv
