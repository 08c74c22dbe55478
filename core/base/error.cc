#include "core/base/error.h"

#include <optional>
#include <utility>

#include "absl/strings/cord.h"
#include "absl/strings/str_cat.h"

namespace curvd {
namespace {

// Names the payload of a status that holds its kind, as one byte.
constexpr char kKindPayload[] = "curvd.core/error_kind";

// Names the payloads that hold its subject.
constexpr std::pair<const char*, std::string ErrorSubject::*> kSubjectPayloads[] = {
    {"curvd.core/field", &ErrorSubject::field},
    {"curvd.core/value", &ErrorSubject::value},
    {"curvd.core/limit", &ErrorSubject::limit},
    {"curvd.core/point", &ErrorSubject::point},
};

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

absl::Status MakeCoreError(ErrorKind kind, std::string_view message, const ErrorSubject& subject) {
  absl::Status status(CodeOf(kind), absl::string_view(message.data(), message.size()));
  const char byte = static_cast<char>(kind);
  status.SetPayload(kKindPayload, absl::Cord(absl::string_view(&byte, 1)));
  for (const auto& [name, part] : kSubjectPayloads) {
    if (!(subject.*part).empty()) status.SetPayload(name, absl::Cord(subject.*part));
  }
  return status;
}

absl::Status InvalidValue(std::string field, std::string value, std::string limit) {
  const std::string message = absl::StrCat(field, " is ", value, "; it must be ", limit);
  return MakeCoreError(ErrorKind::kInvalid, message, {std::move(field), std::move(value), std::move(limit), {}});
}

ErrorKind KindOf(const absl::Status& status) {
  const absl::optional<absl::Cord> payload = status.GetPayload(kKindPayload);
  if (!payload.has_value() || payload->size() != 1) return ErrorKind::kOther;
  return static_cast<ErrorKind>((*payload)[0]);
}

ErrorSubject SubjectOf(const absl::Status& status) {
  ErrorSubject subject;
  for (const auto& [name, part] : kSubjectPayloads) {
    const absl::optional<absl::Cord> payload = status.GetPayload(name);
    if (payload.has_value()) subject.*part = std::string(*payload);
  }
  return subject;
}

}  // namespace curvd
