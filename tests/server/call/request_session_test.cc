#include "server/call/request_session.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "server/rpc/error_reasons.h"
#include "tests/byte_buffers.h"
#include "tests/server/status_matchers.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;

absl::Status Receive(RequestSession& session, const v1::EstimateCurvatureRequest& request) {
  grpc::ByteBuffer message = ToByteBuffer(request.SerializeAsString(), 7);
  return session.Receive(message);
}

constexpr CallLimits kLimits = {100, 2400, 100, 1 << 30, 10};  // 2400 bytes: 100 points of float32
constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;

v1::EstimateCurvatureRequest Header(uint64_t point_count = 0) {
  v1::EstimateCurvatureRequest message;
  message.mutable_header()->set_point_count(point_count);
  return message;
}

std::string Pack(const std::vector<float>& values) {
  return std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float));
}

// `count` points on the x axis with normals along z.
v1::EstimateCurvatureRequest Chunk(uint64_t first, size_t count) {
  std::vector<float> positions, normals;
  for (size_t i = 0; i < count; ++i) {
    positions.insert(positions.end(), {static_cast<float>(first + i), 0.0f, 0.0f});
    normals.insert(normals.end(), {0.0f, 0.0f, 1.0f});
  }
  v1::EstimateCurvatureRequest message;
  message.mutable_chunk()->set_first_index(first);
  message.mutable_chunk()->set_positions(Pack(positions));
  message.mutable_chunk()->set_normals(Pack(normals));
  return message;
}

TEST(RequestSessionTest, CollectsChunksInOrder) {
  RequestSession session(kLimits);
  ASSERT_TRUE(Receive(session, Header(5)).ok());
  ASSERT_TRUE(Receive(session, Chunk(0, 2)).ok());
  ASSERT_TRUE(Receive(session, Chunk(2, 3)).ok());
  EXPECT_EQ(session.points_received(), 5u);
  ASSERT_TRUE(session.HalfClose().ok());
  const Cloud cloud = session.TakeCloud();
  ASSERT_EQ(cloud.size(), 5u);
  EXPECT_EQ(cloud.position(4)[0], 4.0f);
}

TEST(RequestSessionTest, AcceptsACloudWithoutPoints) {
  RequestSession session(kLimits);
  ASSERT_TRUE(Receive(session, Header()).ok());
  ASSERT_TRUE(Receive(session, Chunk(0, 0)).ok());
  ASSERT_TRUE(session.HalfClose().ok());
  EXPECT_EQ(session.TakeCloud().size(), 0u);
}

TEST(RequestSessionTest, RefusesAChunkBeforeTheHeader) {
  RequestSession session(kLimits);
  EXPECT_TRUE(
      IsError(Receive(session, Chunk(0, 1)), kInvalid, kReasonHeaderMissing, {"first message", "chunk", "header"}));
}

TEST(RequestSessionTest, RefusesAStreamWithoutMessages) {
  RequestSession session(kLimits);
  EXPECT_TRUE(IsError(session.HalfClose(), kInvalid, kReasonHeaderMissing, {"header"}));
}

TEST(RequestSessionTest, RefusesBytesThatAreNoMessage) {
  RequestSession session(kLimits);
  ASSERT_TRUE(Receive(session, Header()).ok());
  grpc::ByteBuffer message = ToByteBuffer(std::string(77, '\xff'));
  EXPECT_TRUE(IsError(session.Receive(message), kInvalid, kReasonMessageMalformed, {"message", "77 bytes"}));
  EXPECT_TRUE(IsError(session.HalfClose(), kInvalid, kReasonMessageMalformed, {"77 bytes"}));
}

TEST(RequestSessionTest, TakesAChunkAsNobodyWritesIt) {
  RequestSession session(kLimits);
  ASSERT_TRUE(Receive(session, Header()).ok());
  // Its field twice, with what nobody knows at the end: protobuf merges the one and skips the other.
  v1::EstimateCurvatureRequest index_only;
  index_only.mutable_chunk()->set_first_index(9);
  grpc::ByteBuffer message = ToByteBuffer(index_only.SerializeAsString() + Chunk(0, 3).SerializeAsString() +
                                          std::string("\x12\x02\x08\x00\x78\x01", 6));
  const absl::Status status = session.Receive(message);
  ASSERT_TRUE(status.ok()) << status;
  EXPECT_EQ(session.points_received(), 3u);
}

TEST(RequestSessionTest, RefusesASecondHeader) {
  RequestSession session(kLimits);
  ASSERT_TRUE(Receive(session, Header()).ok());
  EXPECT_TRUE(IsError(Receive(session, Header()), kInvalid, kReasonHeaderRepeated, {"second header", "chunk"}));
}

TEST(RequestSessionTest, RefusesAnEmptyMessage) {
  RequestSession session(kLimits);
  EXPECT_TRUE(IsError(Receive(session, {}), kInvalid, kReasonMessageEmpty, {"empty", "header or a chunk"}));
}

TEST(RequestSessionTest, RefusesGapsRepeatsAndDisorder) {
  for (const uint64_t first : {0, 1, 3, 1000}) {
    RequestSession session(kLimits);
    ASSERT_TRUE(Receive(session, Header()).ok());
    ASSERT_TRUE(Receive(session, Chunk(0, 2)).ok());
    EXPECT_TRUE(IsError(Receive(session, Chunk(first, 1)), kInvalid, kReasonChunkOutOfOrder,
                        {"chunk.first_index", absl::StrCat(first), "must be 2"}));
  }
}

TEST(RequestSessionTest, RefusesLengthsThatAreNoPoints) {
  for (const size_t bytes : {1, 11, 13, 23}) {
    RequestSession session(kLimits);
    ASSERT_TRUE(Receive(session, Header()).ok());
    v1::EstimateCurvatureRequest message = Chunk(0, 2);
    message.mutable_chunk()->mutable_positions()->resize(bytes);
    EXPECT_TRUE(IsError(Receive(session, message), kInvalid, kReasonChunkLength,
                        {"chunk.positions", absl::StrCat(bytes, " bytes"), "multiple of 12"}));
  }
}

TEST(RequestSessionTest, MeasuresFloat64ByItsOwnSize) {
  RequestSession session(kLimits);
  v1::EstimateCurvatureRequest header = Header();
  header.mutable_header()->set_scalar_type(v1::SCALAR_TYPE_FLOAT64);
  ASSERT_TRUE(Receive(session, header).ok());
  EXPECT_TRUE(
      IsError(Receive(session, Chunk(0, 1)), kInvalid, kReasonChunkLength, {"12 bytes", "multiple of 24", "float64"}));
}

TEST(RequestSessionTest, RefusesAPointWithoutNormal) {
  RequestSession session(kLimits);
  ASSERT_TRUE(Receive(session, Header()).ok());
  v1::EstimateCurvatureRequest message = Chunk(0, 2);
  message.mutable_chunk()->mutable_normals()->resize(12);
  EXPECT_TRUE(
      IsError(Receive(session, message), kInvalid, kReasonChunkLength, {"chunk.normals", "12 bytes", "24 bytes"}));
}

TEST(RequestSessionTest, RefusesChunksOverTheByteLimit) {
  RequestSession session(kLimits);
  ASSERT_TRUE(Receive(session, Header()).ok());
  EXPECT_TRUE(IsError(Receive(session, Chunk(0, 101)), absl::StatusCode::kResourceExhausted, kReasonChunkTooLarge,
                      {"chunk.positions", "2424 bytes", "2400", "max_chunk_bytes"}));
}

TEST(RequestSessionTest, RefusesMorePointsThanDeclared) {
  RequestSession session(kLimits);
  ASSERT_TRUE(Receive(session, Header(3)).ok());
  EXPECT_TRUE(
      IsError(Receive(session, Chunk(0, 4)), kInvalid, kReasonPointCountMismatch, {"4", "3", "header.point_count"}));
}

TEST(RequestSessionTest, RefusesFewerPointsThanDeclared) {
  RequestSession session(kLimits);
  ASSERT_TRUE(Receive(session, Header(3)).ok());
  ASSERT_TRUE(Receive(session, Chunk(0, 2)).ok());
  EXPECT_TRUE(IsError(session.HalfClose(), kInvalid, kReasonPointCountMismatch, {"2", "3", "header.point_count"}));
}

v1::EstimateCurvatureRequest MarkingHeader() {
  v1::EstimateCurvatureRequest message = Header();
  message.mutable_header()->set_marks_last_chunk(true);
  return message;
}

v1::EstimateCurvatureRequest LastChunk(uint64_t first, size_t count) {
  v1::EstimateCurvatureRequest message = Chunk(first, count);
  message.mutable_chunk()->set_is_last(true);
  return message;
}

TEST(RequestSessionTest, RefusesAStreamThatWasCutOffBeforeTheLastChunk) {
  RequestSession session(kLimits);
  ASSERT_TRUE(Receive(session, MarkingHeader()).ok());
  ASSERT_TRUE(Receive(session, Chunk(0, 2)).ok());
  EXPECT_TRUE(IsError(session.HalfClose(), kInvalid, kReasonCloudIncomplete, {"2 points", "is_last"}));
}

TEST(RequestSessionTest, RefusesAStreamThatWasCutOffBeforeItsOnlyChunk) {
  RequestSession session(kLimits);
  ASSERT_TRUE(Receive(session, MarkingHeader()).ok());
  EXPECT_TRUE(IsError(session.HalfClose(), kInvalid, kReasonCloudIncomplete, {"0 points"}));
}

TEST(RequestSessionTest, TakesACloudWhoseLastChunkIsMarked) {
  for (const size_t last : {0, 3}) {
    RequestSession session(kLimits);
    ASSERT_TRUE(Receive(session, MarkingHeader()).ok());
    ASSERT_TRUE(Receive(session, Chunk(0, 2)).ok());
    ASSERT_TRUE(Receive(session, LastChunk(2, last)).ok());
    ASSERT_TRUE(session.HalfClose().ok());
    EXPECT_EQ(session.TakeCloud().size(), 2 + last);
  }
}

TEST(RequestSessionTest, RefusesAChunkAfterTheLastOne) {
  RequestSession session(kLimits);
  ASSERT_TRUE(Receive(session, Header()).ok());
  ASSERT_TRUE(Receive(session, LastChunk(0, 2)).ok());
  EXPECT_TRUE(IsError(Receive(session, Chunk(2, 1)), kInvalid, kReasonChunkOutOfOrder, {"is_last", "half-close"}));
}

// A promise that was not made cannot be broken.
TEST(RequestSessionTest, AMarkIsOptionalWithoutThePromise) {
  RequestSession session(kLimits);
  ASSERT_TRUE(Receive(session, Header()).ok());
  ASSERT_TRUE(Receive(session, LastChunk(0, 2)).ok());
  EXPECT_TRUE(session.HalfClose().ok());
}

TEST(RequestSessionTest, BoundsCloudsOfUnknownSize) {
  RequestSession session(kLimits);
  ASSERT_TRUE(Receive(session, Header()).ok());
  ASSERT_TRUE(Receive(session, Chunk(0, 100)).ok());
  EXPECT_TRUE(IsError(Receive(session, Chunk(100, 1)), absl::StatusCode::kResourceExhausted, kReasonTooManyPoints,
                      {"101", "100", "max_points"}));
}

TEST(RequestSessionTest, RefusesAnInvalidPointByItsIndex) {
  RequestSession session(kLimits);
  ASSERT_TRUE(Receive(session, Header()).ok());
  ASSERT_TRUE(Receive(session, Chunk(0, 7)).ok());
  v1::EstimateCurvatureRequest message = Chunk(7, 2);
  message.mutable_chunk()->set_positions(Pack({7, 0, 0, 8, std::nanf(""), 0}));
  EXPECT_TRUE(IsError(Receive(session, message), kInvalid, kReasonInvalidPoint, {"8", "nan"}));
}

TEST(RequestSessionTest, SkipsInvalidPointsOnRequest) {
  RequestSession session(kLimits);
  v1::EstimateCurvatureRequest header = Header();
  header.mutable_header()->set_invalid_point_policy(v1::INVALID_POINT_POLICY_SKIP);
  ASSERT_TRUE(Receive(session, header).ok());
  v1::EstimateCurvatureRequest message = Chunk(0, 2);
  message.mutable_chunk()->set_normals(Pack({0, 0, 0, 0, 0, 1}));
  ASSERT_TRUE(Receive(session, message).ok());
  ASSERT_TRUE(session.HalfClose().ok());
  EXPECT_EQ(session.TakeCloud().invalid_count(), 1u);
}

v1::EstimateCurvatureRequest HeaderWith(v1::NormalSource source) {
  v1::EstimateCurvatureRequest message = Header();
  message.mutable_header()->mutable_normals()->set_source(source);
  return message;
}

v1::EstimateCurvatureRequest BareChunk(uint64_t first, size_t count) {
  v1::EstimateCurvatureRequest message = Chunk(first, count);
  message.mutable_chunk()->clear_normals();
  return message;
}

TEST(RequestSessionTest, NamesTheOptionThatMakesNormalsWhereThereAreNone) {
  for (const v1::NormalSource source : {v1::NORMAL_SOURCE_GIVEN, v1::NORMAL_SOURCE_ORIENT}) {
    RequestSession session(kLimits);
    ASSERT_TRUE(Receive(session, HeaderWith(source)).ok());
    ASSERT_TRUE(Receive(session, Chunk(0, 2)).ok());
    EXPECT_TRUE(IsError(Receive(session, BareChunk(2, 2)), kInvalid, kReasonChunkLength,
                        {"chunk.normals", "0 bytes", "24 bytes", "header.normals.source", "estimate"}));
  }
}

TEST(RequestSessionTest, TakesACloudWithoutNormalsWhereTheyAreEstimated) {
  RequestSession session(kLimits);
  ASSERT_TRUE(Receive(session, HeaderWith(v1::NORMAL_SOURCE_ESTIMATE)).ok());
  ASSERT_TRUE(Receive(session, BareChunk(0, 3)).ok());
  ASSERT_TRUE(session.HalfClose().ok());
  const Cloud cloud = session.TakeCloud();
  EXPECT_EQ(cloud.size(), 3u);
  EXPECT_FALSE(cloud.has_normals());
}

TEST(RequestSessionTest, RefusesNormalsWhereTheyAreEstimated) {
  RequestSession session(kLimits);
  ASSERT_TRUE(Receive(session, HeaderWith(v1::NORMAL_SOURCE_ESTIMATE)).ok());
  ASSERT_TRUE(Receive(session, BareChunk(0, 3)).ok());
  EXPECT_TRUE(IsError(Receive(session, Chunk(3, 1)), kInvalid, kReasonChunkLength,
                      {"chunk.normals", "12 bytes", "absent", "header.normals.source"}));
}

v1::EstimateCurvatureRequest SeenHeader() {
  v1::EstimateCurvatureRequest message = HeaderWith(v1::NORMAL_SOURCE_ESTIMATE);
  message.mutable_header()->mutable_normals()->set_orientation(v1::ORIENTATION_POINT_VIEWPOINTS);
  return message;
}

// A chunk with ids and roles.
v1::EstimateCurvatureRequest PartChunk(size_t count, const std::vector<uint64_t>& ids, const std::string& roles) {
  v1::EstimateCurvatureRequest message = Chunk(0, count);
  message.mutable_chunk()->set_ids(
      std::string(reinterpret_cast<const char*>(ids.data()), ids.size() * sizeof(uint64_t)));
  message.mutable_chunk()->set_roles(roles);
  return message;
}

v1::EstimateCurvatureRequest PartHeader(bool has_ids, bool has_roles) {
  v1::EstimateCurvatureRequest message = Header();
  message.mutable_header()->mutable_part()->set_has_ids(has_ids);
  message.mutable_header()->mutable_part()->set_has_roles(has_roles);
  return message;
}

TEST(RequestSessionTest, TakesIdsAndRoles) {
  RequestSession session(kLimits);
  ASSERT_TRUE(Receive(session, PartHeader(true, true)).ok());
  ASSERT_TRUE(Receive(session, PartChunk(4, {9, ~uint64_t{0}, 3, 4}, std::string("\0\1\2\2", 4))).ok());
  ASSERT_TRUE(session.HalfClose().ok());
  Cloud cloud = session.TakeCloud();
  EXPECT_EQ(cloud.point_set().query_count(), 2u);
  ASSERT_TRUE(cloud.Rank().ok());
  EXPECT_EQ(cloud.record(1).id, 3);
  EXPECT_EQ(cloud.record(2).id, 0);
}

TEST(RequestSessionTest, RefusesIdsAndRolesThatWereNotAnnouncedOrAreMissing) {
  const auto receive = [](bool has_ids, bool has_roles, const std::vector<uint64_t>& ids, const std::string& roles) {
    RequestSession session(kLimits);
    EXPECT_TRUE(Receive(session, PartHeader(has_ids, has_roles)).ok());
    return Receive(session, PartChunk(2, ids, roles));
  };
  EXPECT_TRUE(IsError(receive(false, false, {1, 2}, ""), kInvalid, kReasonChunkLength,
                      {"chunk.ids", "16 bytes", "absent", "header.part.has_ids"}));
  EXPECT_TRUE(IsError(receive(true, false, {1}, ""), kInvalid, kReasonChunkLength,
                      {"chunk.ids", "8 bytes", "16 bytes", "header.part.has_ids"}));
  EXPECT_TRUE(IsError(receive(false, true, {}, ""), kInvalid, kReasonChunkLength,
                      {"chunk.roles", "0 bytes", "2 bytes", "header.part.has_roles"}));
  EXPECT_TRUE(IsError(receive(false, true, {}, "\1\3"), kInvalid, kReasonInvalidPoint,
                      {"role of point 1 is 3", "1 (query) or 2 (halo)"}));
}

v1::EstimateCurvatureRequest SeenChunk(uint64_t first, size_t count, const std::vector<float>& viewpoints) {
  v1::EstimateCurvatureRequest message = BareChunk(first, count);
  message.mutable_chunk()->set_viewpoints(Pack(viewpoints));
  return message;
}

TEST(RequestSessionTest, TakesAViewpointForEachPoint) {
  RequestSession session(kLimits);
  ASSERT_TRUE(Receive(session, SeenHeader()).ok());
  ASSERT_TRUE(Receive(session, SeenChunk(0, 1, {1, 2, 3})).ok());
  ASSERT_TRUE(Receive(session, SeenChunk(1, 2, {4, 5, 6, 7, 8, 9})).ok());
  ASSERT_TRUE(session.HalfClose().ok());
  const Viewpoints viewpoints = session.TakeViewpoints();
  ASSERT_EQ(viewpoints.size(), 3u);
  EXPECT_EQ(viewpoints[2], (std::array<double, 3>{7, 8, 9}));
}

TEST(RequestSessionTest, RefusesViewpointsThatAreTooFewOrNotAskedFor) {
  for (const std::vector<float>& viewpoints : {std::vector<float>{}, {1, 2, 3}, {1, 2, 3, 4, 5, 6, 7, 8, 9}}) {
    RequestSession session(kLimits);
    ASSERT_TRUE(Receive(session, SeenHeader()).ok());
    EXPECT_TRUE(IsError(
        Receive(session, SeenChunk(0, 2, viewpoints)), kInvalid, kReasonChunkLength,
        {"chunk.viewpoints", absl::StrCat(4 * viewpoints.size(), " bytes"), "24 bytes", "header.normals.orientation"}));
  }
  RequestSession session(kLimits);
  ASSERT_TRUE(Receive(session, HeaderWith(v1::NORMAL_SOURCE_ESTIMATE)).ok());
  EXPECT_TRUE(IsError(Receive(session, SeenChunk(0, 1, {1, 2, 3})), kInvalid, kReasonChunkLength,
                      {"chunk.viewpoints", "12 bytes", "absent", "header.normals.orientation"}));
}

v1::EstimateCurvatureRequest TowardHeader() {
  v1::EstimateCurvatureRequest message = HeaderWith(v1::NORMAL_SOURCE_ESTIMATE);
  message.mutable_header()->add_quantities(v1::QUANTITY_NORMAL_CURVATURE);
  return message;
}

v1::EstimateCurvatureRequest TowardChunk(uint64_t first, size_t count, const std::vector<float>& directions) {
  v1::EstimateCurvatureRequest message = BareChunk(first, count);
  message.mutable_chunk()->set_curvature_directions(Pack(directions));
  return message;
}

TEST(RequestSessionTest, TakesADirectionForEachPointWhateverItIs) {
  RequestSession session(kLimits);
  ASSERT_TRUE(Receive(session, TowardHeader()).ok());
  ASSERT_TRUE(Receive(session, TowardChunk(0, 1, {0, 0, 7})).ok());
  ASSERT_TRUE(Receive(session, TowardChunk(1, 2, {0, 0, 0, std::nanf(""), 1, 2})).ok());
  ASSERT_TRUE(session.HalfClose().ok());
  const Directions directions = session.TakeDirections();
  ASSERT_EQ(directions.size(), 3u);
  EXPECT_EQ(directions[0], (Direction{0, 0, 1}));
  EXPECT_EQ(directions[1], Direction{});
  EXPECT_EQ(directions[2], Direction{});
}

TEST(RequestSessionTest, RefusesDirectionsThatAreTooFewOrNotAskedFor) {
  RequestSession session(kLimits);
  ASSERT_TRUE(Receive(session, TowardHeader()).ok());
  EXPECT_TRUE(IsError(Receive(session, TowardChunk(0, 2, {1, 2, 3})), kInvalid, kReasonChunkLength,
                      {"chunk.curvature_directions", "12 bytes", "24 bytes", "header.curvature_direction"}));
  RequestSession one(kLimits);
  v1::EstimateCurvatureRequest header = TowardHeader();
  header.mutable_header()->mutable_curvature_direction()->set_x(1.0);
  ASSERT_TRUE(Receive(one, header).ok());
  EXPECT_TRUE(IsError(Receive(one, TowardChunk(0, 1, {1, 2, 3})), kInvalid, kReasonChunkLength,
                      {"chunk.curvature_directions", "12 bytes", "absent"}));
}

TEST(RequestSessionTest, RefusesAViewpointThatIsNotFinite) {
  RequestSession session(kLimits);
  ASSERT_TRUE(Receive(session, SeenHeader()).ok());
  EXPECT_TRUE(IsError(Receive(session, SeenChunk(0, 2, {1, 2, 3, 4, std::nanf(""), 6})), kInvalid, kReasonInvalidPoint,
                      {"viewpoint of point 1", "(4, nan, 6)", "finite"}));
}

TEST(RequestSessionTest, CountsViewpointsInTheByteLimit) {
  RequestSession session(kLimits);
  ASSERT_TRUE(Receive(session, SeenHeader()).ok());
  EXPECT_TRUE(IsError(Receive(session, SeenChunk(0, 100, std::vector<float>(303))),
                      absl::StatusCode::kResourceExhausted, kReasonChunkTooLarge, {"2412 bytes", "2400"}));
}

TEST(RequestSessionTest, CountsNormalsThatWereRescaled) {
  RequestSession session(kLimits);
  ASSERT_TRUE(Receive(session, Header()).ok());
  v1::EstimateCurvatureRequest message = Chunk(0, 2);
  message.mutable_chunk()->set_normals(Pack({0, 0, 2, 0, 0, 1}));
  ASSERT_TRUE(Receive(session, message).ok());
  EXPECT_EQ(session.normals_rescaled(), 1u);
}

TEST(RequestSessionTest, StaysFailed) {
  RequestSession session(kLimits);
  const absl::Status first = Receive(session, Chunk(0, 1));
  EXPECT_EQ(Receive(session, Header()), first);
  EXPECT_EQ(session.HalfClose(), first);
}

}  // namespace
}  // namespace curvd
