// Reads and writes little-endian scalars among bytes.
#pragma once

#include <cstring>
#include <string>
#include <string_view>

#include "client/io/binary.h"

namespace curv {

// Returns the scalar at byte `at`. REQUIRES: it lies within `bytes`.
template <typename T>
T ScalarAt(std::string_view bytes, size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}

// Replaces the scalar at byte `at`. REQUIRES: it lies within `bytes`.
template <typename T>
void PutScalar(T value, size_t at, std::string& bytes) {
  std::memcpy(bytes.data() + at, &value, sizeof(T));
}

template <typename T>
void AppendScalar(T value, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

// Returns the text in a field of fixed size, which ends at its first zero.
inline std::string_view TextOf(std::string_view field) { return field.substr(0, field.find('\0')); }

}  // namespace curv
