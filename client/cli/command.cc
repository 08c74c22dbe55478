#include "client/cli/command.h"

#include <cstdio>

#include "absl/strings/str_cat.h"

namespace curv {
namespace {

ExitCode CodeFor(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kUnavailable:
      return ExitCode::kUnavailable;
    case absl::StatusCode::kDeadlineExceeded:
      return ExitCode::kTimedOut;
    case absl::StatusCode::kCancelled:
      return ExitCode::kInterrupted;
    default:
      return ExitCode::kFailed;
  }
}

}  // namespace

ExitCode Fail(ExitCode code, const std::string& message) {
  std::fprintf(stderr, "curv: %s\n", message.c_str());
  return code;
}

ExitCode Fail(ExitCode code, const absl::Status& status) { return Fail(code, std::string(status.message())); }

ExitCode FailCall(const absl::Status& status) {
  const ExitCode code = CodeFor(status);
  if (code == ExitCode::kInterrupted) return Fail(code, "interrupted");
  return Fail(code, absl::StrCat(absl::StatusCodeToString(status.code()), ": ", status.message()));
}

void PrintWarning(const std::string& message) { std::fprintf(stderr, "curv: warning: %s\n", message.c_str()); }

void PrintNote(const std::string& message) { std::fprintf(stderr, "curv: note: %s\n", message.c_str()); }

}  // namespace curv
