// JSON objects for programs that call curv.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace curv {

// Collects members in order. Not thread-safe.
class JsonObject {
 public:
  JsonObject& Add(std::string_view name, std::string_view text);
  JsonObject& Add(std::string_view name, const char* text) { return Add(name, std::string_view(text)); }
  JsonObject& Add(std::string_view name, uint64_t number);
  JsonObject& Add(std::string_view name, bool truth);
  // The shortest digits that read back as the same number; null if it is not finite.
  JsonObject& Add(std::string_view name, double number);
  JsonObject& Add(std::string_view name, const JsonObject& object);

  // The object in one line.
  std::string ToString() const { return "{" + members_ + "}"; }

 private:
  void AddRaw(std::string_view name, std::string_view value);

  std::string members_;
};

}  // namespace curv
