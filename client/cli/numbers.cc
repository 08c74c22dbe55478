#include "client/cli/numbers.h"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <iterator>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace curv {

std::string WithCommas(uint64_t number) {
  std::string digits = std::to_string(number);
  for (size_t at = digits.size(); at > 3;) digits.insert(at -= 3, 1, ',');
  return digits;
}

std::string ExactText(double number) {
  char text[32];
  char* const room_end = text + sizeof(text);
  const std::to_chars_result six = std::to_chars(text, room_end, number, std::chars_format::general, 6);
  double read = 0.0;
  std::from_chars(text, six.ptr, read);
  return {text, read == number ? six.ptr : std::to_chars(text, room_end, number).ptr};
}

std::string CountOf(uint64_t number, const char* thing) {
  return absl::StrCat(WithCommas(number), " ", thing, number == 1 ? "" : "s");
}

std::string WithPrefix(double number) {
  static constexpr const char* kPrefixes[] = {"", " k", " M", " G", " T"};
  size_t prefix = 0;
  while (number >= 999.5 && prefix + 1 < std::size(kPrefixes)) {
    number /= 1000.0;
    ++prefix;
  }
  return absl::StrFormat("%.*f%s", number < 9.995 ? 2 : number < 99.95 ? 1 : 0, number, kPrefixes[prefix]);
}

std::string Clock(double seconds) {
  // Beyond a year, it is no news how long exactly.
  const long whole = std::lround(std::fmin(std::fmax(seconds, 0.0), 3e7));
  char text[32];
  if (whole < 60) {
    std::snprintf(text, sizeof(text), "%ld s", whole);
  } else if (whole < 3600) {
    std::snprintf(text, sizeof(text), "%ld:%02ld", whole / 60, whole % 60);
  } else {
    std::snprintf(text, sizeof(text), "%ld:%02ld:%02ld", whole / 3600, whole / 60 % 60, whole % 60);
  }
  return text;
}

}  // namespace curv
