#include "client/report/payload.h"

#include <zlib.h>

#include <utility>

#include "absl/status/status.h"
#include "absl/strings/escaping.h"

namespace curv {

void Payload::Add(std::string name, const std::vector<uint8_t>& scalars) {
  arrays_.push_back({std::move(name), scalars.size(), 1});
  bytes_.append(scalars.begin(), scalars.end());
}

void Payload::Add(std::string name, const std::vector<uint16_t>& scalars) {
  arrays_.push_back({std::move(name), scalars.size(), 2});
  for (const uint16_t scalar : scalars) bytes_.push_back(static_cast<char>(scalar & 0xff));
  for (const uint16_t scalar : scalars) bytes_.push_back(static_cast<char>(scalar >> 8));
}

std::string Payload::TakeBytes() {
  arrays_.clear();
  return std::exchange(bytes_, {});
}

absl::StatusOr<std::string> Payload::Encode() const {
  uLongf size = compressBound(bytes_.size());
  std::string packed(size, '\0');
  const int code = compress2(reinterpret_cast<Bytef*>(packed.data()), &size,
                             reinterpret_cast<const Bytef*>(bytes_.data()), bytes_.size(), Z_DEFAULT_COMPRESSION);
  if (code != Z_OK) return absl::ResourceExhaustedError("not enough memory to compress the points");
  packed.resize(size);
  return absl::Base64Escape(packed);
}

}  // namespace curv
