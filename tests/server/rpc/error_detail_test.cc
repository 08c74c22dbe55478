#include "server/rpc/error_detail.h"

#include <gtest/gtest.h>

#include "google/rpc/error_details.pb.h"

namespace curvd {
namespace {

constexpr char kErrorInfoUrl[] = "type.googleapis.com/google.rpc.ErrorInfo";
constexpr char kRetryInfoUrl[] = "type.googleapis.com/google.rpc.RetryInfo";

google::rpc::ErrorInfo InfoOf(const absl::Status& status) {
  google::rpc::ErrorInfo info;
  const auto payload = status.GetPayload(kErrorInfoUrl);
  EXPECT_TRUE(payload.has_value());
  EXPECT_TRUE(info.ParseFromString(std::string(payload.value_or(absl::Cord()))));
  return info;
}

TEST(MakeErrorTest, NamesFieldValueAndLimit) {
  const absl::Status status =
      MakeError(absl::StatusCode::kInvalidArgument, {"BAD", "header.k", "3", "at least 4", absl::ZeroDuration()});
  EXPECT_EQ(status.message(), "header.k is 3; it must be at least 4");
  const google::rpc::ErrorInfo info = InfoOf(status);
  EXPECT_EQ(info.reason(), "BAD");
  EXPECT_EQ(info.domain(), "curvd");
  EXPECT_EQ(info.metadata().at("field"), "header.k");
  EXPECT_EQ(info.metadata().at("value"), "3");
  EXPECT_EQ(info.metadata().at("limit"), "at least 4");
}

TEST(MakeErrorTest, HasRetryInfoOnlyWhereWaitingHelps) {
  const absl::Status final = MakeError(absl::StatusCode::kResourceExhausted, {"A", "f", "v", "l", {}});
  EXPECT_FALSE(final.GetPayload(kRetryInfoUrl).has_value());
  const absl::Status busy =
      MakeError(absl::StatusCode::kResourceExhausted, {"A", "f", "v", "l", absl::Milliseconds(1500)});
  google::rpc::RetryInfo retry;
  ASSERT_TRUE(retry.ParseFromString(std::string(busy.GetPayload(kRetryInfoUrl).value_or(absl::Cord()))));
  EXPECT_EQ(retry.retry_delay().seconds(), 1);
  EXPECT_EQ(retry.retry_delay().nanos(), 500'000'000);
}

TEST(WithDetailTest, KeepsTheMessageAndLeavesOutWhatIsEmpty) {
  const absl::Status status = WithDetail(absl::CancelledError("gone"), {"CANCELLED", "", "", "", {}});
  EXPECT_EQ(status.message(), "gone");
  EXPECT_TRUE(InfoOf(status).metadata().empty());
}

TEST(ReasonOfTest, FallsBackToTheCode) {
  EXPECT_EQ(ReasonOf(absl::InternalError("x")), "INTERNAL");
  EXPECT_EQ(ReasonOf(WithDetail(absl::InternalError("x"), {"MINE", "", "", "", {}})), "MINE");
}

TEST(WithMetadataTest, AddsAnEntryEvenWithoutADetail) {
  const absl::Status status = WithMetadata(absl::InternalError("x"), "request_id", "7");
  EXPECT_EQ(InfoOf(status).reason(), "INTERNAL");
  EXPECT_EQ(InfoOf(status).metadata().at("request_id"), "7");
}

}  // namespace
}  // namespace curvd
