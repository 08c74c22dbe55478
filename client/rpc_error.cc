#include "client/rpc_error.h"

#include <algorithm>
#include <map>
#include <string>
#include <string_view>

#include "absl/strings/ascii.h"
#include "absl/strings/cord.h"
#include "absl/strings/str_cat.h"
#include "client/curvature_client.h"
#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"

namespace curv {
namespace {

constexpr char kReasonUrl[] = "curvd/error_reason";

template <typename Detail>
std::optional<Detail> FindDetail(const grpc::Status& status) {
  google::rpc::Status details;
  if (!details.ParseFromString(status.error_details())) return std::nullopt;
  for (const google::protobuf::Any& any : details.details()) {
    Detail detail;
    if (any.Is<Detail>() && any.UnpackTo(&detail)) return detail;
  }
  return std::nullopt;
}

// With '?' for what a terminal obeys or a log takes for the end of a line.
std::string WithoutControls(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < ' ' || c == 0x7f; }, '?');
  return text;
}

// Whether a text has the words, and no longer ones in their place: "at most 64" does not say 6.
bool Says(std::string_view text, std::string_view words) {
  const auto goes_on = [](char c) { return absl::ascii_isalnum(static_cast<unsigned char>(c)); };
  if (words.empty()) return true;
  for (size_t at = text.find(words); at != std::string_view::npos; at = text.find(words, at + 1)) {
    const size_t end = at + words.size();
    if ((at == 0 || !goes_on(text[at - 1])) && (end == text.size() || !goes_on(text[end]))) return true;
  }
  return false;
}

// curvd explains each of its own errors, so that an unexplained one came from something on the way.
bool IsTransient(const grpc::Status& status) {
  switch (status.error_code()) {
    case grpc::StatusCode::UNAVAILABLE:
      return true;
    case grpc::StatusCode::UNKNOWN:
    case grpc::StatusCode::INTERNAL:
      return !FindDetail<google::rpc::ErrorInfo>(status).has_value();
    default:
      return false;
  }
}

}  // namespace

absl::Status ToAbslStatus(const grpc::Status& status) {
  if (status.ok()) return absl::OkStatus();
  // The codes are the same numbers.
  const auto code = static_cast<absl::StatusCode>(status.error_code());
  const std::optional<google::rpc::ErrorInfo> info = FindDetail<google::rpc::ErrorInfo>(status);
  if (!info) return absl::Status(code, WithoutControls(status.error_message()));

  const std::string& said = status.error_message();
  std::string message = absl::StrCat(said, " [reason ", info->reason());
  // In the order of their names: the map's own changes from run to run.
  const std::map<std::string, std::string> metadata(info->metadata().begin(), info->metadata().end());
  for (const auto& [key, value] : metadata) {
    if (!Says(said, value)) absl::StrAppend(&message, "; ", key, " ", value);
  }
  absl::Status result(code, WithoutControls(absl::StrCat(message, "]")));
  result.SetPayload(kReasonUrl, absl::Cord(info->reason()));
  return result;
}

std::optional<absl::Duration> RetryDelay(const grpc::Status& status) {
  if (const auto info = FindDetail<google::rpc::RetryInfo>(status)) {
    const absl::Duration delay =
        absl::Seconds(info->retry_delay().seconds()) + absl::Nanoseconds(info->retry_delay().nanos());
    return std::max(delay, absl::ZeroDuration());
  }
  if (!IsTransient(status)) return std::nullopt;
  return absl::ZeroDuration();
}

std::string ErrorReason(const absl::Status& status) {
  const absl::optional<absl::Cord> reason = status.GetPayload(kReasonUrl);
  return reason ? std::string(*reason) : "";
}

}  // namespace curv
