#include "server/observe/json_line.h"

#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

#include "absl/strings/str_cat.h"

namespace curvd {
namespace {

// Callers choose some of the texts: nothing in them may reach a terminal but printable ASCII. Bytes that are not UTF-8
// become U+FFFD.
std::string Quote(const std::string& text) {
  return nlohmann::json(text).dump(/*indent=*/-1, ' ', /*ensure_ascii=*/true, nlohmann::json::error_handler_t::replace);
}

}  // namespace

JsonLine& JsonLine::Add(const char* key, const std::string& value) { return AddRaw(key, Quote(value)); }

JsonLine& JsonLine::Add(const char* key, double value) {
  if (!std::isfinite(value)) return AddRaw(key, "null");
  // A program that embeds the server may have set a locale with another point, which printf would write.
  char digits[32];
  const std::to_chars_result end = std::to_chars(digits, digits + sizeof(digits), value, std::chars_format::general, 6);
  return AddRaw(key, std::string(digits, end.ptr));
}

JsonLine& JsonLine::AddRaw(const char* key, const std::string& value) {
  if (text_.size() > 1) text_ += ',';
  absl::StrAppend(&text_, "\"", key, "\":", value);
  return *this;
}

}  // namespace curvd
