#include "server/net/strangers.h"

#include "absl/strings/match.h"

namespace curvd {
namespace {

// By how much a connection whose handshake takes too long may be closed too early, as gRPC counts in milliseconds, and
// too late, on a machine that is busy.
constexpr auto kEarly = std::chrono::milliseconds(5);
constexpr auto kLate = std::chrono::seconds(2);
// TCP counts the end of what a peer sends as one byte.
constexpr uint64_t kEndBytes = 1;

}  // namespace

std::optional<StrangerReason> WhyStranger(const ConnectionRecord& connection, std::chrono::steady_clock::duration age,
                                          std::chrono::steady_clock::duration handshake_timeout) {
  if (connection.closed_for.has_value()) return connection.closed_for;
  if (connection.let_in_calls > 0 || connection.open_calls > 0) return std::nullopt;
  if (absl::StartsWith(connection.peer, "unix:")) return std::nullopt;
  if (connection.refused_calls > 0) return StrangerReason::kNotLetIn;
  if (age + kEarly >= handshake_timeout && age - handshake_timeout < kLate) return StrangerReason::kHandshakeTimeout;
  return connection.received_bytes <= kEndBytes ? StrangerReason::kNothingSent : StrangerReason::kNoCall;
}

}  // namespace curvd
