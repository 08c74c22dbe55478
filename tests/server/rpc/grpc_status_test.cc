#include "server/rpc/grpc_status.h"

#include <gtest/gtest.h>

#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "server/rpc/error_detail.h"

namespace curvd {
namespace {

TEST(ToGrpcStatusTest, OkHasNothingToSay) {
  const grpc::Status status = ToGrpcStatus(absl::OkStatus(), "id-1");
  EXPECT_TRUE(status.ok());
  EXPECT_TRUE(status.error_details().empty());
}

TEST(ToGrpcStatusTest, CarriesCodeMessageRequestIdAndDetails) {
  const grpc::Status status = ToGrpcStatus(
      MakeError(absl::StatusCode::kResourceExhausted, {"FULL", "calls", "9", "below 9", absl::Seconds(2)}), "id-1");
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(status.error_message(), "calls is 9; it must be below 9 (request id-1)");
  google::rpc::Status details;
  ASSERT_TRUE(details.ParseFromString(status.error_details()));
  EXPECT_EQ(details.code(), static_cast<int>(grpc::StatusCode::RESOURCE_EXHAUSTED));
  EXPECT_EQ(details.message(), status.error_message());
  google::rpc::ErrorInfo info;
  google::rpc::RetryInfo retry;
  for (const google::protobuf::Any& detail : details.details()) {
    if (detail.Is<google::rpc::ErrorInfo>()) detail.UnpackTo(&info);
    if (detail.Is<google::rpc::RetryInfo>()) detail.UnpackTo(&retry);
  }
  EXPECT_EQ(info.reason(), "FULL");
  EXPECT_EQ(info.metadata().at("request_id"), "id-1");
  EXPECT_EQ(retry.retry_delay().seconds(), 2);
}

TEST(CodeNameTest, SpellsCodesAsGrpcDoes) {
  EXPECT_EQ(CodeName(absl::StatusCode::kOk), "OK");
  EXPECT_EQ(CodeName(absl::StatusCode::kDeadlineExceeded), "DEADLINE_EXCEEDED");
}

}  // namespace
}  // namespace curvd
