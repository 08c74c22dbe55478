#include "client/rpc_error.h"

#include <gtest/gtest.h>

#include "client/curvature_client.h"
#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"

namespace curv {
namespace {

grpc::Status WithDetails(bool retry) {
  google::rpc::ErrorInfo info;
  info.set_reason("K_TOO_LARGE");
  info.set_domain("curvd");
  (*info.mutable_metadata())["value"] = "20000";
  (*info.mutable_metadata())["limit"] = "10000";
  google::rpc::Status details;
  details.add_details()->PackFrom(info);
  if (retry) {
    google::rpc::RetryInfo wait;
    wait.mutable_retry_delay()->set_seconds(2);
    wait.mutable_retry_delay()->set_nanos(500'000'000);
    details.add_details()->PackFrom(wait);
  }
  return grpc::Status(grpc::StatusCode::RESOURCE_EXHAUSTED, "too large", details.SerializeAsString());
}

TEST(RpcErrorTest, PutsDetailsIntoTheMessage) {
  const absl::Status status = ToAbslStatus(WithDetails(false));
  EXPECT_TRUE(absl::IsResourceExhausted(status));
  EXPECT_EQ(status.message(), "too large [reason K_TOO_LARGE; limit 10000; value 20000]");
  EXPECT_EQ(ErrorReason(status), "K_TOO_LARGE");
}

TEST(RpcErrorTest, RepeatsNothingThatTheMessageSays) {
  google::rpc::ErrorInfo info;
  info.set_reason("K_TOO_LARGE");
  (*info.mutable_metadata())["value"] = "200";
  (*info.mutable_metadata())["limit"] = "at most 100 (max_k)";
  (*info.mutable_metadata())["seconds"] = "20";
  (*info.mutable_metadata())["nothing"] = "";
  google::rpc::Status details;
  details.add_details()->PackFrom(info);
  const grpc::Status status(grpc::StatusCode::RESOURCE_EXHAUSTED, "k is 200; it must be at most 100 (max_k)",
                            details.SerializeAsString());
  EXPECT_EQ(ToAbslStatus(status).message(),
            "k is 200; it must be at most 100 (max_k) [reason K_TOO_LARGE; seconds 20]");
}

TEST(RpcErrorTest, LetsNoServerWriteOnATerminal) {
  EXPECT_EQ(ToAbslStatus(grpc::Status(grpc::StatusCode::INTERNAL, "a\x1b[2J\r\nb\x7f \u00e9")).message(),
            "a?[2J??b? \u00e9");
  google::rpc::ErrorInfo info;
  info.set_reason("\n");
  (*info.mutable_metadata())["\t"] = "\x01";
  google::rpc::Status details;
  details.add_details()->PackFrom(info);
  const grpc::Status status(grpc::StatusCode::INTERNAL, "m", details.SerializeAsString());
  EXPECT_EQ(ToAbslStatus(status).message(), "m [reason ?; ? ?]");
}

TEST(RpcErrorTest, KeepsPlainErrors) {
  const absl::Status status = ToAbslStatus(grpc::Status(grpc::StatusCode::UNAVAILABLE, "no route"));
  EXPECT_TRUE(absl::IsUnavailable(status));
  EXPECT_EQ(status.message(), "no route");
  EXPECT_EQ(ErrorReason(status), "");
  EXPECT_TRUE(ToAbslStatus(grpc::Status::OK).ok());
}

TEST(RpcErrorTest, IgnoresDamagedDetails) {
  for (const std::string& bytes : {std::string("\xff\xff"), WithDetails(true).error_details().substr(0, 9)}) {
    const grpc::Status damaged(grpc::StatusCode::RESOURCE_EXHAUSTED, "m", bytes);
    EXPECT_EQ(ToAbslStatus(damaged).message(), "m");
    EXPECT_FALSE(RetryDelay(damaged).has_value());
  }
}

TEST(RpcErrorTest, ReadsTheRetryDelay) {
  EXPECT_FALSE(RetryDelay(WithDetails(false)).has_value());
  EXPECT_EQ(RetryDelay(WithDetails(true)), absl::Milliseconds(2500));
}

// curvd gives each of its own errors a reason: one without comes from the way to it, such as a proxy's dead backend.
TEST(RpcErrorTest, ErrorsOfTheWayMayBeRetriedAtOnce) {
  using grpc::StatusCode;
  for (const StatusCode code : {StatusCode::UNAVAILABLE, StatusCode::UNKNOWN, StatusCode::INTERNAL}) {
    EXPECT_EQ(RetryDelay(grpc::Status(code, "reset")), absl::ZeroDuration()) << code;
  }
  const std::string reason = WithDetails(false).error_details();
  EXPECT_EQ(RetryDelay(grpc::Status(StatusCode::UNAVAILABLE, "draining", reason)), absl::ZeroDuration());
  for (const StatusCode code : {StatusCode::UNKNOWN, StatusCode::INTERNAL}) {
    EXPECT_FALSE(RetryDelay(grpc::Status(code, "a defect", reason)).has_value()) << code;
  }
  for (const StatusCode code : {StatusCode::INVALID_ARGUMENT, StatusCode::CANCELLED, StatusCode::DEADLINE_EXCEEDED,
                                StatusCode::RESOURCE_EXHAUSTED, StatusCode::UNIMPLEMENTED}) {
    EXPECT_FALSE(RetryDelay(grpc::Status(code, "no")).has_value()) << code;
  }
}

}  // namespace
}  // namespace curv
