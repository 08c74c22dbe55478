#include "client/cli/command.h"

#include <algorithm>
#include <cstdio>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_replace.h"
#include "client/curvature_client.h"

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

// What the message of an error lacks: where no server gave a reason, gRPC tells of one address and one try alone.
const char* RemedyFor(ExitCode code, const std::string& reason) {
  if (code == ExitCode::kUnavailable && reason.empty()) return ". curv doctor, with the same --server, finds out more";
  // STALLED has the same code.
  const bool is_callers = code == ExitCode::kTimedOut && (reason.empty() || reason == "DEADLINE_EXCEEDED");
  return is_callers ? ": the call took longer than --timeout allows" : "";
}

}  // namespace

std::string Visible(std::string_view text) {
  std::string shown;
  shown.reserve(text.size());
  for (size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const bool is_kept = byte == '\n' || byte == '\t';
    // In UTF-8, U+0080 to U+009F are control characters as well.
    const auto next = i + 1 < text.size() ? static_cast<unsigned char>(text[i + 1]) : 0;
    if (byte == 0xc2 && next >= 0x80 && next <= 0x9f) {
      absl::StrAppendFormat(&shown, "\\x%02x", next);
      ++i;
    } else if ((byte < ' ' && !is_kept) || byte == 0x7f) {
      absl::StrAppendFormat(&shown, "\\x%02x", byte);
    } else {
      shown += text[i];
    }
  }
  return shown;
}

std::string ShellWord(std::string_view text) {
  constexpr std::string_view kPlain = "_-+=./,:@%";
  const bool is_plain = !text.empty() && std::all_of(text.begin(), text.end(), [&](char c) {
    return absl::ascii_isalnum(static_cast<unsigned char>(c)) || kPlain.find(c) != std::string_view::npos;
  });
  if (is_plain) return std::string(text);
  return absl::StrCat("'", absl::StrReplaceAll(Visible(text), {{"'", "'\\''"}}), "'");
}

std::string ShownInput(std::string_view path) { return path == "-" ? "standard input" : Visible(path); }

std::string ShownOutput(std::string_view path) { return path == "-" ? "standard output" : Visible(path); }

ExitCode Fail(ExitCode code, const std::string& message) {
  std::fprintf(stderr, "curv: %s\n", Visible(message).c_str());
  return code;
}

ExitCode Fail(ExitCode code, const absl::Status& status) { return Fail(code, std::string(status.message())); }

ExitCode FailCall(const absl::Status& status, const std::string& title) {
  const ExitCode code = CodeFor(status);
  if (code == ExitCode::kInterrupted) return Fail(code, "interrupted");
  return Fail(code, absl::StrCat(absl::StatusCodeToString(status.code()), ": ", title, status.message(),
                                 RemedyFor(code, std::string(ErrorReason(status)))));
}

void PrintWarning(const std::string& message) { std::fprintf(stderr, "curv: warning: %s\n", Visible(message).c_str()); }

void PrintNote(const std::string& message) { std::fprintf(stderr, "curv: note: %s\n", Visible(message).c_str()); }

}  // namespace curv
