#include "proto/http_date.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <iterator>

#include "absl/strings/str_format.h"

namespace curvd {
namespace {

using Words = std::string_view;
constexpr std::array<Words, 7> kDays = {"Mon", "Tue", "Wed", "Thu", "Fri", "Sat", "Sun"};
constexpr std::array<Words, 12> kMonths = {"Jan", "Feb", "Mar", "Apr", "May", "Jun",
                                           "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"};

// The number that `text` consists of; -1 if it is none.
int Number(std::string_view text) {
  int number = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size() ? number : -1;
}

}  // namespace

std::string FormatHttpDate(absl::Time time) {
  const absl::CivilSecond civil = absl::ToCivilSecond(time, absl::UTCTimeZone());
  return absl::StrFormat("%s, %02d %s %04d %02d:%02d:%02d GMT", kDays[static_cast<size_t>(absl::GetWeekday(civil))],
                         civil.day(), kMonths[static_cast<size_t>(civil.month() - 1)], civil.year(), civil.hour(),
                         civil.minute(), civil.second());
}

std::optional<absl::Time> ParseHttpDate(std::string_view text) {
  if (text.size() != 29) return std::nullopt;
  const auto month = std::find(kMonths.begin(), kMonths.end(), text.substr(8, 3));
  const int year = Number(text.substr(12, 4)), day = Number(text.substr(5, 2));
  const int hour = Number(text.substr(17, 2)), minute = Number(text.substr(20, 2)), second = Number(text.substr(23, 2));
  if (month == kMonths.end() || std::min({year, day, hour, minute, second}) < 0) return std::nullopt;
  const absl::CivilSecond civil(year, std::distance(kMonths.begin(), month) + 1, day, hour, minute, second);
  const absl::Time time = absl::FromCivil(civil, absl::UTCTimeZone());
  // Days and hours that do not exist were carried over to others.
  const std::string_view told = text.substr(3);
  return std::string_view(FormatHttpDate(time)).substr(3) == told ? std::optional(time) : std::nullopt;
}

}  // namespace curvd
