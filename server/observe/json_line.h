// Writes one JSON object on one line, for logs.
#pragma once

#include <concepts>
#include <string>

#include "absl/strings/str_cat.h"

namespace curvd {

// Keys come out in the order in which they were added. Put together by hand, because nlohmann's writer
// cannot be told how many digits a number shall have; the texts are quoted by it. Not thread-safe.
class JsonLine {
 public:
  // What is written is printable ASCII: JSON's escapes stand for all other characters of `value`, and U+FFFD for bytes
  // that are not UTF-8.
  JsonLine& Add(const char* key, const std::string& value);
  JsonLine& Add(const char* key, const char* value) { return Add(key, std::string(value)); }
  JsonLine& Add(const char* key, bool value) { return AddRaw(key, value ? "true" : "false"); }
  // Writes six significant digits; null if the number is not finite.
  JsonLine& Add(const char* key, double value);
  JsonLine& Add(const char* key, std::integral auto value) { return AddRaw(key, absl::StrCat(value)); }

  // The object so far.
  std::string str() const { return text_ + "}"; }

 private:
  JsonLine& AddRaw(const char* key, const std::string& value);

  std::string text_ = "{";
};

}  // namespace curvd
