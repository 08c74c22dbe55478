// Streams that break the protocol, through a real socket. Each must end with the right code and a message that a person
// can act on, and the server must serve the next call as if nothing had happened.
#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/rpc/error_reasons.h"
#include "tests/integration/clouds.h"
#include "tests/integration/test_call.h"
#include "tests/integration/test_server.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;
using grpc::StatusCode;

class ProtocolErrorsTest : public ::testing::Test {
 protected:
  ~ProtocolErrorsTest() override {
    EXPECT_TRUE(Succeeded(Estimate(channel_, HeaderFor(cloud_), cloud_), cloud_.size()));
    server_.WaitUntilIdle();
  }

  // The end of a call in which `send` says everything.
  CallResult Run(const std::function<void(TestCall&)>& send) {
    TestCall call(channel_);
    send(call);
    call.HalfClose();
    return call.Finish();
  }

  TestServer server_;
  std::shared_ptr<grpc::Channel> channel_ = server_.NewChannel();
  const TestCloud cloud_ = Sphere(100, 1.0f);
};

TEST_F(ProtocolErrorsTest, MissingHeader) {
  const CallResult result = Run([&](TestCall& call) { call.SendCloud(cloud_); });
  EXPECT_TRUE(FailedWith(result, StatusCode::INVALID_ARGUMENT, kReasonHeaderMissing, {"first message", "a header"}));
}

TEST_F(ProtocolErrorsTest, NothingAtAll) {
  const CallResult result = Run([](TestCall&) {});
  EXPECT_TRUE(FailedWith(result, StatusCode::INVALID_ARGUMENT, kReasonHeaderMissing, {"stream", "a header"}));
}

TEST_F(ProtocolErrorsTest, TwoHeaders) {
  const CallResult result = Run([&](TestCall& call) {
    call.SendHeader(HeaderFor(cloud_));
    call.SendHeader(HeaderFor(cloud_));
  });
  EXPECT_TRUE(FailedWith(result, StatusCode::INVALID_ARGUMENT, kReasonHeaderRepeated, {"second header", "a chunk"}));
}

TEST_F(ProtocolErrorsTest, EmptyMessage) {
  const CallResult result = Run([&](TestCall& call) { call.Send({}); });
  EXPECT_TRUE(FailedWith(result, StatusCode::INVALID_ARGUMENT, kReasonMessageEmpty, {"empty", "header or a chunk"}));
}

TEST_F(ProtocolErrorsTest, ChunksOutOfOrder) {
  const CallResult result = Run([&](TestCall& call) {
    call.SendHeader(HeaderFor(cloud_));
    call.SendPoints(cloud_, 0, 10);
    call.SendPoints(cloud_, 20, 10);
  });
  EXPECT_TRUE(
      FailedWith(result, StatusCode::INVALID_ARGUMENT, kReasonChunkOutOfOrder, {"chunk.first_index", "20", "10"}));
  EXPECT_EQ(result.metadata.at("field"), "chunk.first_index");
  EXPECT_EQ(result.metadata.at("value"), "20");
}

TEST_F(ProtocolErrorsTest, ChunkSentTwice) {
  const CallResult result = Run([&](TestCall& call) {
    call.SendHeader(HeaderFor(cloud_));
    call.SendPoints(cloud_, 0, 10);
    call.SendPoints(cloud_, 0, 10);
  });
  EXPECT_TRUE(
      FailedWith(result, StatusCode::INVALID_ARGUMENT, kReasonChunkOutOfOrder, {"chunk.first_index", "0", "10"}));
}

TEST_F(ProtocolErrorsTest, LengthsThatAreNoPoints) {
  const CallResult result = Run([&](TestCall& call) {
    call.SendHeader({});
    TestCall::Request message;
    message.mutable_chunk()->set_positions(std::string(13, 'x'));
    call.Send(message);
  });
  EXPECT_TRUE(FailedWith(result, StatusCode::INVALID_ARGUMENT, kReasonChunkLength,
                         {"chunk.positions", "13 bytes", "multiple of 12"}));
}

TEST_F(ProtocolErrorsTest, FewerNormalsThanPositions) {
  const CallResult result = Run([&](TestCall& call) {
    call.SendHeader({});
    TestCall::Request message;
    message.mutable_chunk()->set_positions(cloud_.PackedPositions(0, 3));
    message.mutable_chunk()->set_normals(cloud_.PackedNormals(0, 2));
    call.Send(message);
  });
  EXPECT_TRUE(
      FailedWith(result, StatusCode::INVALID_ARGUMENT, kReasonChunkLength, {"chunk.normals", "24 bytes", "36 bytes"}));
}

TEST_F(ProtocolErrorsTest, HalfCloseTooEarly) {
  const CallResult result = Run([&](TestCall& call) {
    call.SendHeader(HeaderFor(cloud_));
    call.SendPoints(cloud_, 0, 60);
  });
  EXPECT_TRUE(
      FailedWith(result, StatusCode::INVALID_ARGUMENT, kReasonPointCountMismatch, {"60", "100", "header.point_count"}));
}

TEST_F(ProtocolErrorsTest, MorePointsThanDeclared) {
  const CallResult result = Run([&](TestCall& call) {
    v1::CloudHeader header;
    header.set_point_count(50);
    call.SendHeader(header);
    call.SendCloud(cloud_);
  });
  EXPECT_TRUE(
      FailedWith(result, StatusCode::INVALID_ARGUMENT, kReasonPointCountMismatch, {"100", "50", "header.point_count"}));
}

TEST_F(ProtocolErrorsTest, ChunkOverTheLimit) {
  const CallResult result = Run([&](TestCall& call) {
    call.SendHeader({});
    TestCall::Request message;
    message.mutable_chunk()->mutable_positions()->resize(2'400'000);
    message.mutable_chunk()->mutable_normals()->resize(2'400'000);
    call.Send(message);
  });
  EXPECT_TRUE(FailedWith(result, StatusCode::RESOURCE_EXHAUSTED, kReasonChunkTooLarge,
                         {"chunk.positions", "4800000 bytes", "4194304", "max_chunk_bytes"}));
  EXPECT_FALSE(result.retry_seconds.has_value());
}

// Far above the limit gRPC drops the message before our code sees it. That must not look like the end of a stream.
TEST_F(ProtocolErrorsTest, OversizedMessage) {
  const CallResult result = Run([&](TestCall& call) {
    call.SendHeader({});
    call.SendCloud(cloud_);
    TestCall::Request message;
    message.mutable_chunk()->set_first_index(100);
    message.mutable_chunk()->mutable_positions()->resize(12'000'000);
    call.Send(message);
  });
  EXPECT_EQ(result.status.error_code(), StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_NE(result.status.error_message().find("12000"), std::string::npos) << result.status.error_message();
  EXPECT_NE(result.status.error_message().find("5242880"), std::string::npos) << result.status.error_message();
  EXPECT_FALSE(result.summary.has_value());
}

TEST_F(ProtocolErrorsTest, OptionOutOfItsRange) {
  v1::CloudHeader header;
  header.mutable_options()->set_neighbor_count(3);
  const CallResult result = Run([&](TestCall& call) { call.SendHeader(header); });
  EXPECT_TRUE(FailedWith(result, StatusCode::INVALID_ARGUMENT, kReasonInvalidOption,
                         {"header.options.neighbor_count", "3", "at least 4"}));
  EXPECT_EQ(result.metadata.at("limit"), "at least 4");
}

TEST_F(ProtocolErrorsTest, NeighborhoodOverTheLimit) {
  v1::CloudHeader header;
  header.mutable_options()->set_neighbor_count(10'001);
  const CallResult result = Run([&](TestCall& call) { call.SendHeader(header); });
  EXPECT_TRUE(FailedWith(result, StatusCode::RESOURCE_EXHAUSTED, kReasonNeighborhoodTooLarge,
                         {"header.options.neighbor_count", "10001", "10000", "max_neighbor_count"}));
}

TEST_F(ProtocolErrorsTest, RadiusThatCoversTooManyPoints) {
  const TestCloud cloud = Sphere(20'000, 1.0f);
  v1::CloudHeader header = HeaderFor(cloud);
  header.mutable_options()->set_radius(10.0);
  const CallResult result = Estimate(channel_, header, cloud);
  EXPECT_TRUE(FailedWith(result, StatusCode::RESOURCE_EXHAUSTED, kReasonNeighborhoodTooLarge,
                         {"radius 10", "10000 neighbors", "limit"}));
  EXPECT_EQ(result.metadata.at("field"), "header.options.radius");
  EXPECT_EQ(result.metadata.at("value"), "10");
  EXPECT_EQ(result.metadata.at("limit"), "so small that no point has more than 10000 neighbors (max_neighbor_count)");
  EXPECT_EQ(result.metadata.count("point"), 1u);
  EXPECT_FALSE(result.retry_seconds.has_value());
}

// What a cloud is refused for is told to programs as well, with the place of the point, whatever its id.
TEST_F(ProtocolErrorsTest, PointsThatAreRefused) {
  using Metadata = std::map<std::string, std::string>;
  const auto refuse = [&](const v1::CloudHeader& header, const std::function<void(v1::PointChunk&)>& spoil) {
    const CallResult result = Run([&](TestCall& call) {
      call.SendHeader(header);
      TestCall::Request message;
      message.mutable_chunk()->set_positions(cloud_.PackedPositions(0, 100));
      message.mutable_chunk()->set_normals(cloud_.PackedNormals(0, 100));
      spoil(*message.mutable_chunk());
      call.Send(message);
    });
    Metadata metadata = result.metadata;
    metadata.erase("request_id");
    return metadata;
  };
  const auto zero_at_7 = [](v1::PointChunk& chunk) { chunk.mutable_normals()->replace(7 * 12, 12, 12, '\0'); };
  EXPECT_EQ(
      refuse({}, zero_at_7),
      (Metadata{{"field", "chunk.normals"}, {"point", "7"}, {"value", "(0, 0, 0)"}, {"limit", "finite and not zero"}}));
  v1::CloudHeader part;
  part.mutable_part()->set_has_roles(true);
  EXPECT_EQ(refuse(part, [](v1::PointChunk& chunk) { chunk.set_roles(std::string(40, '\1') + std::string(60, '\3')); }),
            (Metadata{{"field", "chunk.roles"}, {"point", "40"}, {"value", "3"}, {"limit", "1 (query) or 2 (halo)"}}));
  part.mutable_part()->set_has_roles(false);
  part.mutable_part()->set_has_ids(true);
  std::vector<uint64_t> ids(100);
  for (size_t i = 0; i < ids.size(); ++i) ids[i] = 1'000 - i;
  ids[9] = ids[5];
  const std::string packed(reinterpret_cast<const char*>(ids.data()), ids.size() * sizeof(uint64_t));
  EXPECT_EQ(
      refuse(part, [&](v1::PointChunk& chunk) { chunk.set_ids(packed); }),
      (Metadata{{"field", "chunk.ids"}, {"point", "9"}, {"value", "995"}, {"limit", "other than that of point 5"}}));
}

TEST_F(ProtocolErrorsTest, TagThatALogCannotShow) {
  v1::CloudHeader header;
  header.set_request_tag("a\nb");
  const CallResult result = Run([&](TestCall& call) { call.SendHeader(header); });
  EXPECT_TRUE(
      FailedWith(result, StatusCode::INVALID_ARGUMENT, kReasonInvalidOption, {"header.request_tag[1]", "0x0a"}));
}

// A few bytes could unpack to gigabytes.
TEST_F(ProtocolErrorsTest, CompressedMessage) {
  TestCall call(channel_, std::nullopt, GRPC_COMPRESS_GZIP);
  call.SendHeader(HeaderFor(cloud_));
  call.SendCloud(cloud_);
  call.HalfClose();
  const CallResult result = call.Finish();
  EXPECT_EQ(result.status.error_code(), StatusCode::UNIMPLEMENTED);
  EXPECT_NE(result.status.error_message().find("gzip"), std::string::npos) << result.status.error_message();
}

// Bytes that are no message of ours, after a header without a point_count: nothing else tells that points are missing.
TEST_F(ProtocolErrorsTest, BytesThatAreNoMessage) {
  grpc::ClientContext context;
  const grpc::internal::RpcMethod method("/curvature.v1.CurvatureService/EstimateCurvature",
                                         grpc::internal::RpcMethod::BIDI_STREAMING, channel_);
  std::unique_ptr<grpc::ClientReaderWriter<grpc::ByteBuffer, grpc::ByteBuffer>> stream(
      grpc::internal::ClientReaderWriterFactory<grpc::ByteBuffer, grpc::ByteBuffer>::Create(channel_.get(), method,
                                                                                            &context));
  TestCall::Request header;
  header.mutable_header();
  const grpc::Slice first(header.SerializeAsString()), garbage("\xff\xff\xff\xff garbage");
  stream->Write(grpc::ByteBuffer(&first, 1));
  stream->Write(grpc::ByteBuffer(&garbage, 1));
  stream->WritesDone();
  grpc::ByteBuffer answer;
  while (stream->Read(&answer)) {
  }
  const grpc::Status status = stream->Finish();
  EXPECT_EQ(status.error_code(), StatusCode::INVALID_ARGUMENT);
  EXPECT_NE(status.error_message().find("12 bytes that cannot be parsed"), std::string::npos) << status.error_message();
}

}  // namespace
}  // namespace curvd
