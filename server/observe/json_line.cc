#include "server/observe/json_line.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "absl/strings/str_format.h"

namespace curvd {
namespace {

// Whether a terminal takes the character that begins at text[i] for a command: DEL, or one of U+0080 to U+009F. JSON
// escapes the other control characters.
bool IsControl(const std::string& text, size_t i) {
  const auto byte = [&text](size_t at) { return static_cast<unsigned char>(text[at]); };
  return byte(i) == 0x7f || (byte(i) == 0xc2 && i + 1 < text.size() && byte(i + 1) < 0xa0);
}

// Callers choose some of the texts. Bytes that are not UTF-8 become U+FFFD.
std::string Quote(const std::string& text) {
  const std::string json =
      nlohmann::json(text).dump(/*indent=*/-1, ' ', /*ensure_ascii=*/false, nlohmann::json::error_handler_t::replace);
  std::string quoted;
  for (size_t i = 0; i < json.size(); ++i) {
    if (!IsControl(json, i)) {
      quoted += json[i];
      continue;
    }
    if (json[i] != '\x7f') ++i;  // the second byte is the character's number
    absl::StrAppendFormat(&quoted, "\\u%04x", static_cast<unsigned>(static_cast<unsigned char>(json[i])));
  }
  return quoted;
}

}  // namespace

JsonLine& JsonLine::Add(const char* key, const std::string& value) { return AddRaw(key, Quote(value)); }

JsonLine& JsonLine::Add(const char* key, double value) {
  return AddRaw(key, std::isfinite(value) ? absl::StrFormat("%.6g", value) : "null");
}

JsonLine& JsonLine::AddRaw(const char* key, const std::string& value) {
  if (text_.size() > 1) text_ += ',';
  absl::StrAppend(&text_, "\"", key, "\":", value);
  return *this;
}

}  // namespace curvd
