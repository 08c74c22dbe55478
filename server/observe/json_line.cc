#include "server/observe/json_line.h"

#include <cmath>

#include "absl/strings/str_format.h"

namespace curvd {
namespace {

std::string Quote(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (c < ' ' || c > '~') {  // bytes, which need not be UTF-8: a line stays ASCII whatever comes in
      quoted += absl::StrFormat("\\u%04x", static_cast<unsigned>(static_cast<unsigned char>(c)));
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
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
