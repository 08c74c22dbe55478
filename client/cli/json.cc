#include "client/cli/json.h"

#include <charconv>
#include <cmath>
#include <cstdio>

namespace curv {
namespace {

// Bytes that are not ASCII are kept: file names are taken to be UTF-8.
std::string Quote(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (static_cast<unsigned char>(c) < 0x20) {
      char escaped[8];
      std::snprintf(escaped, sizeof(escaped), "\\u%04x", static_cast<unsigned>(c));
      quoted += escaped;
    } else {
      quoted += c;
    }
  }
  return quoted + "\"";
}

}  // namespace

void JsonObject::AddRaw(std::string_view name, std::string_view value) {
  if (!members_.empty()) members_ += ", ";
  members_ += Quote(name);
  members_ += ": ";
  members_ += value;
}

JsonObject& JsonObject::Add(std::string_view name, std::string_view text) {
  AddRaw(name, Quote(text));
  return *this;
}

JsonObject& JsonObject::Add(std::string_view name, bool truth) {
  AddRaw(name, truth ? "true" : "false");
  return *this;
}

JsonObject& JsonObject::Add(std::string_view name, uint64_t number) {
  AddRaw(name, std::to_string(number));
  return *this;
}

JsonObject& JsonObject::Add(std::string_view name, double number) {
  char digits[32];
  const std::to_chars_result result = std::to_chars(digits, digits + sizeof(digits), number);
  AddRaw(name, std::isfinite(number) ? std::string_view(digits, static_cast<size_t>(result.ptr - digits)) : "null");
  return *this;
}

JsonObject& JsonObject::Add(std::string_view name, const JsonObject& object) {
  AddRaw(name, object.ToString());
  return *this;
}

}  // namespace curv
