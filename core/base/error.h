// Why the core could not do what it was asked: errors that callers tell apart by kind, never by the words of a message.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/status.h"

namespace curvd {

enum class ErrorKind : uint8_t {
  kInvalid,               // an option or a point is out of its range; INVALID_ARGUMENT
  kOutOfMemory,           // the system gave no memory; RESOURCE_EXHAUSTED
  kNeighborhoodTooLarge,  // a radius gives a point more neighbors than max_neighbor_count; RESOURCE_EXHAUSTED
  kOpposedNormals,        // normals contradict each other, and the caller wants no such cloud; INVALID_ARGUMENT
  kRepeatedId,            // two points have the same id; INVALID_ARGUMENT
  kCancelled,             // somebody cancelled the work; CANCELLED
  kOther,                 // a status that the core did not make, or a defect
};

// What an error is about, for programs; a string is empty where there is no such thing.
struct ErrorSubject {
  std::string field;  // the name of an option, or of an array of points
  std::string value;  // what it is
  std::string limit;  // what it must be, as a phrase after "must be": "at least 4"
  std::string point;  // the place in the input of the point that has the value, from 0
};

// Returns a status of the code that stands beside `kind` above, with `message`; INTERNAL for kOther.
absl::Status MakeCoreError(ErrorKind kind, std::string_view message, const ErrorSubject& subject = {});

// Returns the error of kind kInvalid of an option, with the message "FIELD is VALUE; it must be LIMIT".
absl::Status InvalidValue(std::string field, std::string value, std::string limit);

// Returns the kind that MakeCoreError gave to `status`; kOther for every other status.
// REQUIRES: !status.ok().
ErrorKind KindOf(const absl::Status& status);

// Returns the subject that `status` was made with; an empty one for every other status. REQUIRES: !status.ok().
ErrorSubject SubjectOf(const absl::Status& status);

}  // namespace curvd
