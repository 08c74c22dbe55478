#include "proto/bulk_message.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>
#include <string>

#include "curvature/v1/curvature.pb.h"
#include "tests/byte_buffers.h"

namespace curvature::wire {
namespace {

using curvd::ToByteBuffer;
using v1::EstimateCurvatureRequest;
using v1::PointChunk;

constexpr BulkLayout kLayout({PointChunk::kFirstIndexFieldNumber},
                             {PointChunk::kPositionsFieldNumber, PointChunk::kNormalsFieldNumber});

EstimateCurvatureRequest Chunk(uint64_t first, size_t bytes) {
  EstimateCurvatureRequest request;
  request.mutable_chunk()->set_first_index(first);
  for (size_t i = 0; i < bytes; ++i) {
    request.mutable_chunk()->mutable_positions()->push_back(static_cast<char>(i % 251));
    request.mutable_chunk()->mutable_normals()->push_back(static_cast<char>(i % 241));
  }
  return request;
}

std::string Joined(const Pieces& pieces) {
  std::string joined;
  for (const std::string_view piece : pieces) joined += piece;
  return joined;
}

bool Read(grpc::ByteBuffer& message, BulkMessage& read) {
  return ReadBulkMessage(message, EstimateCurvatureRequest::kChunkFieldNumber, kLayout, read);
}

bool IsRead(std::string_view bytes) {
  grpc::ByteBuffer message = ToByteBuffer(bytes);
  BulkMessage read;
  return Read(message, read);
}

TEST(ReadBulkMessageTest, ReadsWhatProtobufWrites) {
  for (const uint64_t first : {uint64_t{0}, uint64_t{1}, uint64_t{300}, uint64_t{0xffffffff}}) {
    for (const size_t size : {0, 1, 127, 128, 70'000}) {
      const EstimateCurvatureRequest request = Chunk(first, size);
      for (const size_t piece_bytes : {1, 7, 4096, 1 << 20}) {
        if (size / piece_bytes > 1000) continue;
        grpc::ByteBuffer message = ToByteBuffer(request.SerializeAsString(), piece_bytes);
        BulkMessage read;
        ASSERT_TRUE(Read(message, read)) << first << ", " << size << " bytes in pieces of " << piece_bytes;
        EXPECT_EQ(read.numbers[PointChunk::kFirstIndexFieldNumber], first);
        EXPECT_EQ(SizeOf(read.arrays[PointChunk::kPositionsFieldNumber]), size);
        EXPECT_EQ(Joined(read.arrays[PointChunk::kPositionsFieldNumber]), request.chunk().positions());
        EXPECT_EQ(Joined(read.arrays[PointChunk::kNormalsFieldNumber]), request.chunk().normals());
      }
    }
  }
}

TEST(ReadBulkMessageTest, ReadsFieldsWhoseTagTakesTwoBytes) {
  constexpr BulkLayout kSixteen({v1::ResultChunk::kPointCountFieldNumber},
                                {v1::ResultChunk::kMeanCurvatureStandardErrorFieldNumber});
  static_assert(v1::ResultChunk::kMeanCurvatureStandardErrorFieldNumber == 16);
  v1::EstimateCurvatureResponse response;
  response.mutable_result()->set_point_count(2);
  response.mutable_result()->set_mean_curvature_standard_error("12345678");
  for (const size_t piece_bytes : {1, 7, 4096}) {
    grpc::ByteBuffer message = ToByteBuffer(response.SerializeAsString(), piece_bytes);
    BulkMessage read;
    ASSERT_TRUE(ReadBulkMessage(message, v1::EstimateCurvatureResponse::kResultFieldNumber, kSixteen, read));
    EXPECT_EQ(Joined(read.arrays[16]), "12345678");
  }
}

TEST(ReadBulkMessageTest, CopiesNoArray) {
  const std::string bytes = Chunk(3, 1000).SerializeAsString();
  const grpc::Slice slice(bytes);
  grpc::ByteBuffer message(&slice, 1);
  BulkMessage read;
  ASSERT_TRUE(Read(message, read));
  const std::string_view normals = read.arrays[PointChunk::kNormalsFieldNumber].front();
  EXPECT_EQ(reinterpret_cast<const uint8_t*>(normals.data() + normals.size()), slice.end());
}

TEST(ReadBulkMessageTest, LeavesAllElseToProtobuf) {
  const std::string chunk = Chunk(3, 5).SerializeAsString();
  EXPECT_TRUE(IsRead(chunk));
  EXPECT_FALSE(IsRead(""));
  EXPECT_FALSE(IsRead(chunk.substr(0, chunk.size() - 1)));  // cut off
  EXPECT_FALSE(IsRead(chunk + chunk));                      // twice
  EXPECT_FALSE(IsRead(chunk + '\0'));                       // more behind it
  EXPECT_FALSE(IsRead(Chunk(uint64_t{1} << 32, 5).SerializeAsString()));
  EXPECT_FALSE(IsRead(std::string_view("\x0a\x00", 2)));                      // a header
  EXPECT_FALSE(IsRead(std::string_view("\x12\x01\x00", 3)));                  // a tag that is none
  EXPECT_FALSE(IsRead(std::string_view("\x92\x80\x80\x80\x80\x00\x00", 7)));  // a tag in six bytes
  EXPECT_FALSE(IsRead(std::string_view("\x12\x03\x88\x00\x01", 5)));          // a tag in two bytes
  EXPECT_FALSE(IsRead("\x12\x80\x80\x80\x80\x80\x80\x80\x80\x80\x01"));       // a length in ten bytes
  EXPECT_FALSE(IsRead("\x12\x04\x08\x01\x08\x02"));                           // first_index twice
  EXPECT_FALSE(IsRead("\x12\x02\x10\x01"));                                   // positions as a number
  EXPECT_FALSE(IsRead("\x12\x02\x78\x01"));                                   // a field that nobody knows
  EXPECT_FALSE(IsRead("\x12\x02\x12\x7f"));                                   // positions longer than the chunk
  EXPECT_FALSE(IsRead("\x12\xff\xff\xff\xff\x0f\x08"));                       // a chunk of 4 GiB
  EXPECT_FALSE(IsRead(std::string_view("\x12\x02\x08\x80", 4)));
}

// Whatever is read is what protobuf reads, for messages with any byte changed, cut out or put in.
TEST(ReadBulkMessageTest, AgreesWithProtobufOnDamagedMessages) {
  std::mt19937 random(1);
  int read_count = 0;
  for (int round = 0; round < 20'000; ++round) {
    std::string bytes = Chunk(random() % 500, random() % 20).SerializeAsString();
    for (int changes = random() % 3; changes >= 0 && !bytes.empty(); --changes) {
      const size_t at = random() % bytes.size();
      switch (random() % 3) {
        case 0:
          bytes[at] = static_cast<char>(random());
          break;
        case 1:
          bytes.erase(at, 1);
          break;
        default:
          bytes.insert(at, 1, static_cast<char>(random() % 2 == 0 ? random() % 40 : 0x80));
      }
    }
    grpc::ByteBuffer message = ToByteBuffer(bytes, 1 + random() % 30);
    BulkMessage read;
    if (!Read(message, read)) continue;
    ++read_count;
    EstimateCurvatureRequest request;
    ASSERT_TRUE(request.ParseFromString(bytes));
    ASSERT_TRUE(request.has_chunk());
    ASSERT_EQ(request.chunk().first_index(), read.numbers[PointChunk::kFirstIndexFieldNumber]);
    ASSERT_EQ(request.chunk().positions(), Joined(read.arrays[PointChunk::kPositionsFieldNumber]));
    ASSERT_EQ(request.chunk().normals(), Joined(read.arrays[PointChunk::kNormalsFieldNumber]));
  }
  EXPECT_GT(read_count, 1000);
}

TEST(BulkWriterTest, WritesTheBytesOfProtobuf) {
  for (const uint64_t first : {uint64_t{0}, uint64_t{1}, uint64_t{127}, uint64_t{128}, ~uint64_t{0}}) {
    for (const size_t size : {1, 100, 127, 128, 16'384}) {
      const EstimateCurvatureRequest request = Chunk(first, size);
      char *positions = nullptr, *normals = nullptr;
      BulkWriter writer(EstimateCurvatureRequest::kChunkFieldNumber);
      writer.AddNumber(PointChunk::kFirstIndexFieldNumber, first);
      writer.AddArray(PointChunk::kPositionsFieldNumber, size, &positions);
      writer.AddArray(PointChunk::kNormalsFieldNumber, size, &normals);
      const grpc::Slice message = writer.Finish([&] {
        std::memcpy(positions, request.chunk().positions().data(), size);
        std::memcpy(normals, request.chunk().normals().data(), size);
      });
      EXPECT_EQ(std::string(message.begin(), message.end()), request.SerializeAsString());
    }
  }
}

}  // namespace
}  // namespace curvature::wire
