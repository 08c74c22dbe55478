// Messages of a few numbers and large arrays, read and written where gRPC has their bytes.
//
// protobuf keeps a `bytes` field in a string of its own, so that every array is copied once more on its way in and once
// more on its way out. For arrays that is most of what a message costs.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string_view>

#include "absl/container/inlined_vector.h"
#include "absl/functional/function_ref.h"
#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/slice.h"

namespace curvature::wire {

// One past the largest field number that is read in place.
inline constexpr int kFieldEnd = 32;

// The bytes of a field, in the pieces in which they were received.
using Pieces = absl::InlinedVector<std::string_view, 16>;

size_t SizeOf(const Pieces& pieces);

// Which fields a message may have. Numbers are varints, arrays are `bytes`; all field numbers are below kFieldEnd.
class BulkLayout {
 public:
  constexpr BulkLayout(std::initializer_list<int> numbers, std::initializer_list<int> arrays)
      : numbers_(BitsOf(numbers)), arrays_(BitsOf(arrays)) {}
  // Allows one more array. REQUIRES: field < kFieldEnd.
  constexpr void AddArray(int field) { arrays_ |= uint32_t{1} << field; }
  constexpr bool HasNumber(uint32_t field) const { return field < kFieldEnd && (numbers_ >> field & 1) != 0; }
  constexpr bool HasArray(uint32_t field) const { return field < kFieldEnd && (arrays_ >> field & 1) != 0; }

 private:
  static constexpr uint32_t BitsOf(std::initializer_list<int> fields) {
    uint32_t bits = 0;
    for (const int field : fields) bits |= uint32_t{1} << field;
    return bits;
  }
  uint32_t numbers_;
  uint32_t arrays_;
};

// What was read, by field number; 0 and no pieces for what was not there.
struct BulkMessage {
  std::array<uint64_t, kFieldEnd> numbers{};
  std::array<Pieces, kFieldEnd> arrays;
};

// Reads `message` if it is nothing but its field `field`, a message with fields of `layout`, each at most once: what
// every protobuf library writes. Numbers must be below 2^32. The pieces lie in `message` and live as long. Returns
// false for all else, wrong or merely unusual, which is protobuf's to parse; `read` is then undefined.
bool ReadBulkMessage(grpc::ByteBuffer& message, int field, const BulkLayout& layout, BulkMessage& read);

// Lays out a message whose one field `field` is a message of numbers and arrays, as protobuf would serialize it. Add
// in ascending order of field numbers.
class BulkWriter {
 public:
  explicit BulkWriter(int field) : field_(field) {}
  // Not written if 0, as in proto3.
  void AddNumber(int field, uint64_t value);
  // *place is set by Finish. REQUIRES: bytes > 0.
  void AddArray(int field, size_t bytes, char** place);
  // The message. `fill` is called once, when all places are set, and writes the arrays there.
  grpc::Slice Finish(absl::FunctionRef<void()> fill) const;

 private:
  struct Entry {
    int field;
    uint64_t value;  // of an array: its number of bytes
    char** place;    // nullptr: a number
  };

  int field_;
  absl::InlinedVector<Entry, 10> entries_;
};

}  // namespace curvature::wire
