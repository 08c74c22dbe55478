// Stands in for gRPC in tests of streams: notes what is asked of it, and answers when the test says so.
#pragma once

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

#include "server/rpc/bidi_stream.h"
#include "tests/byte_buffers.h"

namespace curvd {

class FakeTransport : public BidiTransport {
 public:
  // BidiTransport; breaks of its rules are test failures.
  void StartRead(grpc::ByteBuffer* message) override {
    EXPECT_FALSE(finished.has_value()) << "a read after Finish";
    EXPECT_EQ(reading, nullptr) << "two reads at a time";
    reading = message;
    ++reads;
  }
  void StartWrite(const grpc::ByteBuffer* message) override {
    EXPECT_FALSE(finished.has_value()) << "a write after Finish";
    EXPECT_FALSE(is_writing) << "two writes at a time";
    is_writing = true;
    grpc::Slice slice;
    EXPECT_TRUE(message->DumpToSingleSlice(&slice).ok());
    written.emplace_back(reinterpret_cast<const char*>(slice.begin()), slice.size());
  }
  void Finish(const grpc::Status& status) override {
    EXPECT_FALSE(finished.has_value()) << "Finish twice";
    EXPECT_FALSE(is_writing) << "Finish while a write is in flight";
    finished = status;
  }
  void TryCancel() override {
    EXPECT_FALSE(finished.has_value()) << "TryCancel after Finish";
    ++cancels;
  }

  // The peer's message arrives. REQUIRES: a read is in flight.
  void Deliver(BidiStream& stream, const std::string& message) {
    ASSERT_NE(reading, nullptr);
    *std::exchange(reading, nullptr) = ToByteBuffer(message);
    stream.OnReadDone(true);
  }
  // The peer half-closes, or is gone.
  void DeliverEnd(BidiStream& stream) {
    ASSERT_NE(reading, nullptr);
    reading = nullptr;
    stream.OnReadDone(false);
  }
  // The write in flight is over.
  void EndWrite(BidiStream& stream, bool ok = true) {
    ASSERT_TRUE(is_writing);
    is_writing = false;
    stream.OnWriteDone(ok);
  }

  grpc::ByteBuffer* reading = nullptr;
  int reads = 0;
  bool is_writing = false;
  std::vector<std::string> written;
  std::optional<grpc::Status> finished;
  int cancels = 0;
};

}  // namespace curvd
