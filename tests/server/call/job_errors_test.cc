#include "server/call/job_errors.h"

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "server/rpc/error_reasons.h"
#include "tests/server/status_matchers.h"

namespace curvd {
namespace {

TEST(ExplainJobErrorTest, TellsALargeNeighborhoodFromALackOfMemory) {
  EXPECT_TRUE(IsError(ExplainJobError(MakeCoreError(ErrorKind::kNeighborhoodTooLarge, "radius 9 gives 11 neighbors")),
                      absl::StatusCode::kResourceExhausted, kReasonNeighborhoodTooLarge, {"radius 9"}));
  EXPECT_TRUE(IsError(ExplainJobError(MakeCoreError(ErrorKind::kOutOfMemory, "no pages")),
                      absl::StatusCode::kResourceExhausted, kReasonOutOfMemory, {"no pages"}));
}

TEST(ExplainJobErrorTest, TellsOpposedNormals) {
  EXPECT_TRUE(IsError(ExplainJobError(MakeCoreError(ErrorKind::kOpposedNormals, "normals of 7 points are opposed")),
                      absl::StatusCode::kInvalidArgument, kReasonOpposedNormals, {"7 points"}));
}

TEST(ExplainJobErrorTest, AnythingElseIsADefect) {
  EXPECT_TRUE(IsError(ExplainJobError(absl::CancelledError("nobody asked")), absl::StatusCode::kInternal,
                      kReasonInternal, {"nobody asked"}));
}

TEST(ExplainJobErrorTest, ACodeAloneSaysNothing) {
  EXPECT_TRUE(IsError(ExplainJobError(absl::ResourceExhaustedError("out of memory: somebody else's")),
                      absl::StatusCode::kInternal, kReasonInternal, {"somebody else's"}));
}

TEST(ExplainCloudErrorTest, TellsAnInvalidPointFromALackOfMemory) {
  EXPECT_TRUE(IsError(ExplainCloudError(MakeCoreError(ErrorKind::kInvalid, "point 7")),
                      absl::StatusCode::kInvalidArgument, kReasonInvalidPoint, {"point 7"}));
  EXPECT_TRUE(IsError(ExplainCloudError(MakeCoreError(ErrorKind::kOutOfMemory, "no pages")),
                      absl::StatusCode::kResourceExhausted, kReasonOutOfMemory, {"no pages"}));
}

TEST(ExplainJobErrorTest, TellsProgramsWhatTheCoreSays) {
  const absl::Status status = ExplainJobError(
      MakeCoreError(ErrorKind::kNeighborhoodTooLarge, "radius 9 gives 11", {"radius", "9", "less", "3"}),
      "header.normals.radius");
  EXPECT_EQ(MetadataOf(status, "field"), "header.normals.radius");
  EXPECT_EQ(MetadataOf(status, "value"), "9");
  EXPECT_EQ(MetadataOf(status, "limit"), "less");
  EXPECT_EQ(MetadataOf(status, "point"), "3");
}

TEST(ExplainCloudErrorTest, NamesTheArrayOfTheRequest) {
  const absl::Status status =
      ExplainCloudError(MakeCoreError(ErrorKind::kInvalid, "role 3", {"roles", "3", "1 or 2", "40"}));
  EXPECT_EQ(MetadataOf(status, "field"), "chunk.roles");
  EXPECT_EQ(MetadataOf(status, "value"), "3");
  EXPECT_EQ(MetadataOf(status, "limit"), "1 or 2");
  EXPECT_EQ(MetadataOf(status, "point"), "40");
}

TEST(ExplainCloudErrorTest, LeavesNothingOfTheCoreAttached) {
  const absl::Status status = ExplainCloudError(MakeCoreError(ErrorKind::kInvalid, "point 7"));
  EXPECT_EQ(KindOf(status), ErrorKind::kOther);
}

}  // namespace
}  // namespace curvd
