// The time in a header of HTTP (RFC 9110, section 5.6.7), by which a client sees how far its clock is from the
// server's.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "absl/time/time.h"

namespace curvd {

// The name of the header, which curvd sends with the answer to GetServerInfo.
inline constexpr char kDateHeader[] = "date";

// "Sun, 06 Nov 1994 08:49:37 GMT", whatever the locale; fractions of seconds are cut off.
std::string FormatHttpDate(absl::Time time);

// Reads what FormatHttpDate writes; nothing of any other text. The day of the week is not compared with the date.
std::optional<absl::Time> ParseHttpDate(std::string_view text);

}  // namespace curvd
