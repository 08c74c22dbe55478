// Turns std::bad_alloc into an error, at the places where one caller's work must not end the process.
#pragma once

#include <new>
#include <utility>

#include "absl/status/status.h"
#include "core/base/error.h"

namespace curvd {

// The error of kind kOutOfMemory that CatchBadAlloc returns. It was made when the process had memory, so that a copy of
// it allocates nothing.
inline const absl::Status& OutOfMemoryError() {
  static const absl::Status& error = *new absl::Status(
      MakeCoreError(ErrorKind::kOutOfMemory, "out of memory: the system gave no memory for the work on this cloud"));
  return error;
}

// Makes the error that OutOfMemoryError returns. Called once, early, by whoever starts threads that may need it.
inline void PrepareOutOfMemoryError() { (void)OutOfMemoryError(); }

// Returns what `work` returns, or OutOfMemoryError() if it throws std::bad_alloc. `Work` returns an absl::Status or an
// absl::StatusOr.
template <typename Work>
auto CatchBadAlloc(Work&& work) -> decltype(work()) {
  try {
    return std::forward<Work>(work)();
  } catch (const std::bad_alloc&) {
    return OutOfMemoryError();
  }
}

}  // namespace curvd
