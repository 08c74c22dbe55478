// Packs arrays into the text that a report holds them in.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace curv {

// Where an array lies in the bytes that the page gets when it has inflated them.
struct PackedArray {
  std::string name;
  size_t count;             // of scalars
  size_t bytes_per_scalar;  // 1 or 2
};

// Collects arrays one after the other. Those of two bytes a scalar are kept as all low bytes, then all high bytes,
// which deflate packs better. Not thread-safe.
class Payload {
 public:
  void Add(std::string name, const std::vector<uint8_t>& scalars);
  void Add(std::string name, const std::vector<uint16_t>& scalars);

  const std::vector<PackedArray>& arrays() const { return arrays_; }
  // Returns the arrays as one zlib stream (RFC 1950) in base64 (RFC 4648, section 4). RESOURCE_EXHAUSTED if zlib gets
  // no memory.
  absl::StatusOr<std::string> Encode() const;
  // Returns the arrays as they are; the payload has none any more.
  std::string TakeBytes();

 private:
  std::vector<PackedArray> arrays_;
  std::string bytes_;
};

}  // namespace curv
