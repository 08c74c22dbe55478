#include "client/cli/doctor/answers.h"

#include <memory>
#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/time/clock.h"
#include "client/cli/numbers.h"
#include "client/curvature_client.h"
#include "client/io/text.h"

namespace curv {
namespace {

// "0.1" of "0.1.7": what may differ without a word.
std::string_view Series(std::string_view version) {
  const size_t dot = version.find('.');
  return version.substr(0, version.find('.', dot == std::string_view::npos ? dot : dot + 1));
}

void CompareVersions(const ServerInfo& info, const ExamineOptions& options, const std::string& prefix,
                     Findings& findings) {
  const std::string version = Printable(info.version);
  if (Series(info.version) == Series(options.client_version)) {
    findings.Ok("version", absl::StrCat(prefix, "curvd ", version, ", curv ", options.client_version));
    return;
  }
  findings.Warn("version", absl::StrCat(prefix, "curvd ", version, ", but curv ", options.client_version),
                "the contract only grows, so that calls work; take the older one's successor for what is new");
}

void TellLimits(const ServerInfo& info, const std::string& prefix, Findings& findings) {
  findings.Ok(
      "limits",
      absl::StrCat(prefix, WithCommas(info.max_points), " points a cloud, ", WithCommas(info.max_neighbor_count),
                   " a neighborhood, ", WithCommas(info.max_streams), " open calls, ",
                   info.memory_bytes == 0 ? "memory not limited"
                                          : WithPrefix(static_cast<double>(info.memory_bytes)) + "B for all"));
}

void CompareClocks(const ServerInfo& info, absl::Time asked, absl::Time answered, const std::string& prefix,
                   Findings& findings) {
  if (!info.date.has_value()) {
    findings.Ok("clock", absl::StrCat(prefix, "not compared: this server does not tell its time"));
    return;
  }
  // The server's time is cut to seconds, and was read somewhere between question and answer.
  const absl::Duration ahead = *info.date + absl::Milliseconds(500) - (asked + (answered - asked) / 2);
  const absl::Duration off = absl::AbsDuration(ahead);
  if (off <= absl::Seconds(5) + (answered - asked) / 2) {
    findings.Ok("clock", absl::StrCat(prefix, "the server's and this machine's agree to 5 s"));
    return;
  }
  findings.Warn(
      "clock",
      absl::StrCat(prefix, "the server's is ", absl::FormatDuration(absl::Trunc(off, absl::Seconds(1))),
                   ahead > absl::ZeroDuration() ? " ahead of" : " behind", " this machine's"),
      "have both set by NTP (`timedatectl`): certificates are good by the clock, and logs cannot be compared");
}

void TellHealth(const std::string& health, const std::string& prefix, Findings& findings) {
  if (health == "SERVING") return findings.Ok("health", prefix + health);
  if (health == "NOT_SERVING") {
    return findings.Fault("health", prefix + "NOT_SERVING: the server drains, and takes no more clouds",
                          "ask another replica, or wait until it has been started again");
  }
  findings.Warn("health", absl::StrCat(prefix, health),
                "no grpc.health.v1 answers: a proxy on the way may let through too little");
}

// What a refusal means, by its code and reason.
void ExplainRefusal(const absl::Status& status, const std::string& prefix, const ExamineOptions& options,
                    Findings& findings) {
  const std::string says = absl::StrCat(prefix, status.message());
  const std::string reason = ErrorReason(status);
  if (reason == "TOKEN_MISSING") {
    return findings.Fault("caller", says, "the server asks for a token: --token-file FILE, or the variable CURV_TOKEN");
  }
  if (reason == "TOKEN_INVALID") {
    return findings.Fault("caller", says,
                          "have the administrator look whether the token's line is in curvd's --token-file");
  }
  switch (status.code()) {
    case absl::StatusCode::kUnauthenticated:
    case absl::StatusCode::kPermissionDenied:
      return findings.Fault("caller", says, "have the administrator let in this certificate or token");
    case absl::StatusCode::kUnimplemented:
      return findings.Fault("version", absl::StrCat(prefix, "speaks gRPC, but not curvature.v1: ", status.message()),
                            "ask curvd: another gRPC service listens on this port");
    case absl::StatusCode::kUnavailable:
      return findings.Fault("answer", says, "start curvd there; if it runs, look for what ends connections on the way");
    case absl::StatusCode::kDeadlineExceeded:
      return findings.Fault("answer", absl::StrCat(prefix, "no answer within ", absl::FormatDuration(options.timeout)),
                            "look whether the machine is overloaded, or give more time (--timeout)");
    default:
      return findings.Fault("answer", says, "look into the log of curvd");
  }
}

}  // namespace

void AskWhatItSays(const std::string& target, const std::string& prefix, const ExamineOptions& options,
                   Findings& findings) {
  const absl::StatusOr<std::unique_ptr<CurvatureClient>> client = CurvatureClient::Connect(target, options.connect);
  if (!client.ok()) {
    return findings.Fault("caller", absl::StrCat(prefix, client.status().message()),
                          "mend the flags, or the variables CURV_...");
  }
  const absl::Time asked = absl::Now();
  const absl::StatusOr<ServerInfo> info = (*client)->GetServerInfo(options.timeout);
  const absl::Time answered = absl::Now();
  if (!info.ok()) {
    ExplainRefusal(info.status(), prefix, options, findings);
    if (const auto health = (*client)->GetHealth(options.timeout); health.ok()) TellHealth(*health, prefix, findings);
    return;
  }
  CompareVersions(*info, options, prefix, findings);
  findings.Ok("caller", absl::StrCat(prefix, options.connect.token.empty() ? "let in without a token" : "let in"));
  TellHealth(info->health, prefix, findings);
  TellLimits(*info, prefix, findings);
  CompareClocks(*info, asked, answered, prefix, findings);
}

}  // namespace curv
