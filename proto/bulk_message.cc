#include "proto/bulk_message.h"

#include <google/protobuf/io/coded_stream.h>
#include <grpc/slice.h>

#include <algorithm>
#include <bit>
#include <limits>

#include "grpcpp/support/proto_buffer_reader.h"

#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define CURVD_THREAD_SANITIZER 1
extern "C" void __tsan_acquire(void* address);
extern "C" void __tsan_release(void* address);
#endif
#endif

namespace curvature::wire {
namespace {

using google::protobuf::io::CodedInputStream;
using google::protobuf::io::CodedOutputStream;

static_assert(std::endian::native == std::endian::little, "the wire format is little-endian");

constexpr uint64_t kMaxNumber = std::numeric_limits<uint32_t>::max();

// Wire types of https://protobuf.dev/programming-guides/encoding.
constexpr uint32_t kVarint = 0, kLengthDelimited = 2;

constexpr uint32_t Tag(int field, uint32_t wire_type) { return static_cast<uint32_t>(field) << 3 | wire_type; }

// gRPC comes from the distribution without instrumentation. Where both sides share a process, the thread sanitizer does
// not see that it hands a message from one thread to another; these tell it. `bytes` is where the message begins.
#if CURVD_THREAD_SANITIZER
void NoteSent(const uint8_t* bytes) { __tsan_release(const_cast<uint8_t*>(bytes)); }
void NoteReceived(const void* bytes) { __tsan_acquire(const_cast<void*>(bytes)); }
#else
void NoteSent(const uint8_t* /*bytes*/) {}
void NoteReceived(const void* /*bytes*/) {}
#endif

// A tag that is written in as few bytes as it takes; 0: there is none, or another.
uint32_t ReadShortTag(CodedInputStream& input) {
  const int before = input.CurrentPosition();
  const uint32_t tag = input.ReadTag();
  const auto bytes = static_cast<int>(CodedOutputStream::VarintSize32(tag));
  return input.CurrentPosition() == before + bytes ? tag : 0;
}

bool ReadPieces(CodedInputStream& input, Pieces& pieces) {
  int length = 0;
  if (!input.ReadVarintSizeAsInt(&length) || length > input.BytesUntilLimit()) return false;
  for (int left = length; left > 0;) {
    const void* data = nullptr;
    int size = 0;
    if (!input.GetDirectBufferPointer(&data, &size)) return false;
    size = std::min(size, left);
    pieces.emplace_back(static_cast<const char*>(data), size);
    if (!input.Skip(size)) return false;
    left -= size;
  }
  return true;
}

// Reads up to the limit of `input`.
bool ReadFields(CodedInputStream& input, const BulkLayout& layout, BulkMessage& read) {
  uint32_t seen = 0;
  while (input.BytesUntilLimit() > 0) {
    const uint32_t tag = ReadShortTag(input), field = tag >> 3;
    if (tag == 0 || field >= kFieldEnd || (seen >> field & 1) != 0) return false;
    seen |= uint32_t{1} << field;
    if (tag == Tag(field, kVarint) && layout.HasNumber(field)) {
      if (!input.ReadVarint64(&read.numbers[field]) || read.numbers[field] > kMaxNumber) return false;
    } else if (tag == Tag(field, kLengthDelimited) && layout.HasArray(field)) {
      if (!ReadPieces(input, read.arrays[field])) return false;
    } else {
      return false;
    }
  }
  return true;
}

// Of a tag and a varint.
size_t NumberBytes(int field, uint64_t value) {
  return CodedOutputStream::VarintSize32(Tag(field, kVarint)) + CodedOutputStream::VarintSize64(value);
}

uint8_t* WriteNumber(uint32_t tag, uint64_t value, uint8_t* out) {
  return CodedOutputStream::WriteVarint64ToArray(value, CodedOutputStream::WriteVarint32ToArray(tag, out));
}

}  // namespace

size_t SizeOf(const Pieces& pieces) {
  size_t size = 0;
  for (const std::string_view piece : pieces) size += piece.size();
  return size;
}

bool ReadBulkMessage(grpc::ByteBuffer& message, int field, const BulkLayout& layout, BulkMessage& read) {
  grpc::ProtoBufferReader reader(&message);
  CodedInputStream input(&reader);
  const void* begin = nullptr;
  int length = 0;
  if (input.GetDirectBufferPointer(&begin, &length)) NoteReceived(begin);
  if (ReadShortTag(input) != Tag(field, kLengthDelimited) || !input.ReadVarintSizeAsInt(&length)) return false;
  if (static_cast<size_t>(input.CurrentPosition()) + static_cast<size_t>(length) != message.Length()) return false;
  input.PushLimit(length);
  return ReadFields(input, layout, read);
}

void BulkWriter::AddNumber(int field, uint64_t value) {
  if (value != 0) entries_.push_back({field, value, nullptr});
}

void BulkWriter::AddArray(int field, size_t bytes, char** place) { entries_.push_back({field, bytes, place}); }

grpc::Slice BulkWriter::Finish(absl::FunctionRef<void()> fill) const {
  size_t size = 0;
  for (const Entry& entry : entries_) {
    size += NumberBytes(entry.field, entry.value) + (entry.place == nullptr ? 0 : entry.value);
  }
  // Not grpc_slice_malloc, whose short slices hold their bytes themselves: no address of theirs lasts.
  grpc_slice message = grpc_slice_malloc_large(NumberBytes(field_, size) + size);
  uint8_t* out = WriteNumber(Tag(field_, kLengthDelimited), size, GRPC_SLICE_START_PTR(message));
  for (const Entry& entry : entries_) {
    if (entry.place == nullptr) {
      out = WriteNumber(Tag(entry.field, kVarint), entry.value, out);
    } else {
      out = WriteNumber(Tag(entry.field, kLengthDelimited), entry.value, out);
      *entry.place = reinterpret_cast<char*>(out);
      out += entry.value;
    }
  }
  fill();
  NoteSent(GRPC_SLICE_START_PTR(message));
  return {message, grpc::Slice::STEAL_REF};
}

}  // namespace curvature::wire
