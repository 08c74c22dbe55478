#include "server/rpc/error_detail.h"

#include <utility>

#include "absl/strings/cord.h"
#include "absl/strings/str_cat.h"
#include "absl/types/optional.h"
#include "google/rpc/error_details.pb.h"

namespace curvd {
namespace {

constexpr char kErrorInfoUrl[] = "type.googleapis.com/google.rpc.ErrorInfo";
constexpr char kRetryInfoUrl[] = "type.googleapis.com/google.rpc.RetryInfo";

google::rpc::ErrorInfo ErrorInfoOf(const absl::Status& status) {
  google::rpc::ErrorInfo info;
  const absl::optional<absl::Cord> payload = status.GetPayload(kErrorInfoUrl);
  if (payload.has_value()) info.ParseFromString(std::string(*payload));
  return info;
}

void Attach(const google::rpc::ErrorInfo& info, absl::Status& status) {
  status.SetPayload(kErrorInfoUrl, absl::Cord(info.SerializeAsString()));
}

}  // namespace

absl::Status MakeError(absl::StatusCode code, const ErrorDetail& detail) {
  const std::string message = absl::StrCat(detail.field, " is ", detail.value, "; it must be ", detail.limit);
  return WithDetail(absl::Status(code, message), detail);
}

absl::Status WithDetail(absl::Status status, const ErrorDetail& detail) {
  google::rpc::ErrorInfo info;
  info.set_reason(detail.reason);
  info.set_domain(kErrorDomain);
  auto& metadata = *info.mutable_metadata();
  if (!detail.field.empty()) metadata["field"] = detail.field;
  if (!detail.value.empty()) metadata["value"] = detail.value;
  if (!detail.limit.empty()) metadata["limit"] = detail.limit;
  // What the core attached is not for callers.
  status = absl::Status(status.code(), status.message());
  Attach(info, status);
  if (detail.retry_after > absl::ZeroDuration()) {
    google::rpc::RetryInfo retry;
    const int64_t nanos = absl::ToInt64Nanoseconds(detail.retry_after);
    retry.mutable_retry_delay()->set_seconds(nanos / 1'000'000'000);
    retry.mutable_retry_delay()->set_nanos(static_cast<int32_t>(nanos % 1'000'000'000));
    status.SetPayload(kRetryInfoUrl, absl::Cord(retry.SerializeAsString()));
  }
  return status;
}

std::string ReasonOf(const absl::Status& status) {
  const google::rpc::ErrorInfo info = ErrorInfoOf(status);
  return info.reason().empty() ? absl::StatusCodeToString(status.code()) : info.reason();
}

absl::Status WithMetadata(absl::Status status, const std::string& key, const std::string& value) {
  google::rpc::ErrorInfo info = ErrorInfoOf(status);
  if (info.reason().empty()) info.set_reason(absl::StatusCodeToString(status.code()));
  info.set_domain(kErrorDomain);
  (*info.mutable_metadata())[key] = value;
  Attach(info, status);
  return status;
}

}  // namespace curvd
