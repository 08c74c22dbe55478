#include "core/base/error.h"

#include <optional>

#include "absl/strings/cord.h"

namespace curvd {
namespace {

// Names the payload of a status that holds its kind, as one byte.
constexpr char kKindPayload[] = "curvd.core/error_kind";

absl::StatusCode CodeOf(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::kInvalid:
    case ErrorKind::kOpposedNormals:
    case ErrorKind::kRepeatedId:
      return absl::StatusCode::kInvalidArgument;
    case ErrorKind::kOutOfMemory:
    case ErrorKind::kNeighborhoodTooLarge:
      return absl::StatusCode::kResourceExhausted;
    case ErrorKind::kCancelled:
      return absl::StatusCode::kCancelled;
    case ErrorKind::kOther:
      break;
  }
  return absl::StatusCode::kInternal;
}

}  // namespace

absl::Status MakeCoreError(ErrorKind kind, std::string_view message) {
  absl::Status status(CodeOf(kind), absl::string_view(message.data(), message.size()));
  const char byte = static_cast<char>(kind);
  status.SetPayload(kKindPayload, absl::Cord(absl::string_view(&byte, 1)));
  return status;
}

ErrorKind KindOf(const absl::Status& status) {
  const absl::optional<absl::Cord> payload = status.GetPayload(kKindPayload);
  if (!payload.has_value() || payload->size() != 1) return ErrorKind::kOther;
  return static_cast<ErrorKind>((*payload)[0]);
}

}  // namespace curvd
