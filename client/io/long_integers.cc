#include "client/io/long_integers.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <variant>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/io/text.h"

namespace curv {
namespace {

// The double nearest to an integer, which may be 2^63 or 2^64 where that has no such bits.
template <typename Integer>
double Nearest(Integer integer, bool& exact) {
  constexpr double kEnd = std::is_signed_v<Integer> ? 0x1p63 : 0x1p64;
  const auto value = static_cast<double>(integer);
  exact = exact && value < kEnd && static_cast<Integer>(value) == integer;
  return value;
}

}  // namespace

bool AppendLongIntegers(const char* first, size_t count, size_t stride, bool swap, bool is_signed, Column& column) {
  auto& values = std::get<std::vector<double>>(column.values);
  values.reserve(values.size() + count);
  bool exact = true;
  for (size_t i = 0; i < count; ++i) {
    uint64_t bits;
    std::memcpy(&bits, first + i * stride, sizeof(bits));
    if (swap) bits = __builtin_bswap64(bits);
    values.push_back(is_signed ? Nearest(static_cast<int64_t>(bits), exact) : Nearest(bits, exact));
  }
  return exact;
}

bool IsRounded(std::string_view text, double value) {
  constexpr size_t kExactDigits = 15;  // 10^15 < 2^53
  if (text.size() <= kExactDigits) return false;
  if (text.front() == '-' || text.front() == '+') text.remove_prefix(1);
  if (text.find_first_not_of("0123456789") != std::string_view::npos) return false;
  text.remove_prefix(std::min(text.find_first_not_of('0'), text.size()));
  if (text.size() <= kExactDigits) return false;
  return absl::StrFormat("%.0f", std::abs(value)) != text;
}

void NoteRounded(const std::set<std::string>& columns, std::vector<std::string>& notes) {
  for (const std::string& name : columns) {
    notes.push_back(absl::StrCat("column ", Printable(name), " is rounded: integers beyond 2^53 are not all doubles"));
  }
}

}  // namespace curv
