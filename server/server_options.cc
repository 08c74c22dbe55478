#include "server/server_options.h"

#include <algorithm>
#include <string>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "server/host/memory_limit.h"
#include "server/host/processor_limit.h"
#include "server/net/listen_address.h"
#include "server/rpc/error_detail.h"
#include "server/rpc/error_reasons.h"

namespace curvd {
namespace {

constexpr uint32_t kMaxPort = 65535;

absl::Status CheckRange(const char* flag, uint64_t value, uint64_t low, uint64_t high) {
  if (value >= low && value <= high) return absl::OkStatus();
  return MakeError(absl::StatusCode::kInvalidArgument,
                   {kReasonInvalidOption, flag, absl::StrCat(value), absl::StrCat("in [", low, ", ", high, "]"), {}});
}

absl::Status CheckAbove0(const char* flag, absl::Duration value) {
  if (value > absl::ZeroDuration()) return absl::OkStatus();
  return MakeError(absl::StatusCode::kInvalidArgument,
                   {kReasonInvalidOption, flag, absl::FormatDuration(value), "above 0s", {}});
}

// `flag` makes sense only with `other`.
absl::Status CheckGoesWith(const char* flag, const std::string& value, const char* other,
                           const std::string& other_value) {
  if (value.empty() || !other_value.empty()) return absl::OkStatus();
  return MakeError(absl::StatusCode::kInvalidArgument,
                   {kReasonInvalidOption, flag, value, absl::StrCat("given together with ", other), {}});
}

bool HasHostAndPort(const std::string& address) {
  const auto [host, port] = SplitHostPort(address);
  const bool is_number = !port.empty() && std::all_of(port.begin(), port.end(), absl::ascii_isdigit);
  uint32_t number = 0;
  return !host.empty() && is_number && absl::SimpleAtoi(port, &number) && number <= kMaxPort;
}

// Whether a host is an address of this machine shows when it is bound.
absl::Status CheckAddress(const char* flag, const std::string& address) {
  if (address.empty() || absl::StartsWith(address, "unix:") || HasHostAndPort(address)) return absl::OkStatus();
  return MakeError(absl::StatusCode::kInvalidArgument,
                   {kReasonInvalidOption,
                    flag,
                    address,
                    absl::StrCat("HOST:PORT with a port in [0, ", kMaxPort, "], or unix:PATH"),
                    {}});
}

// Debian's civetweb, which answers scrapes, knows neither IPv6 nor Unix sockets.
absl::Status CheckMetricsAddress(const std::string& address) {
  const std::string host = SplitHostPort(address).host;
  if (address.empty() || (HasHostAndPort(address) && host != "*" && !absl::StrContains(host, ':') &&
                          !absl::StartsWith(address, "unix:"))) {
    return absl::OkStatus();
  }
  return MakeError(absl::StatusCode::kInvalidArgument,
                   {kReasonInvalidOption,
                    "--metrics-listen",
                    address,
                    absl::StrCat("HOST:PORT with an IPv4 address, or a name of one, and a port in [0, ", kMaxPort, "]"),
                    {}});
}

absl::Status CheckReach(const ServerOptions& options) {
  if (IsLocalAddress(options.listen) || !options.tls_cert.empty() || options.insecure) return absl::OkStatus();
  return MakeError(absl::StatusCode::kInvalidArgument,
                   {kReasonInvalidOption,
                    "--listen",
                    options.listen,
                    "a loopback address, unless --tls-cert and --tls-key encrypt what other machines send, or "
                    "--insecure says that they may send it in plain text",
                    {}});
}

}  // namespace

absl::Status ServerOptions::Validate() const {
  constexpr uint64_t kMinMemory = 32 << 20;
  if (threads < 0 || threads > 4096) {
    return MakeError(absl::StatusCode::kInvalidArgument,
                     {kReasonInvalidOption, "--threads", absl::StrCat(threads), "in [0, 4096]", {}});
  }
  const absl::Status checks[] = {
      CheckRange("--max-points", max_points, 1, (uint64_t{1} << 31) - 1),
      CheckRange("--max-chunk-bytes", max_chunk_bytes, 1 << 10, 256 << 20),
      CheckRange("--max-neighbor-count", max_neighbor_count, 4, 1'000'000),
      CheckRange("--memory-limit", memory_limit_bytes == 0 ? kMinMemory : memory_limit_bytes, kMinMemory,
                 uint64_t{1} << 50),
      CheckRange("--max-streams", max_streams, 1, 100'000),
      CheckRange("--max-streams-per-peer", max_streams_per_peer, 1, 100'000),
      CheckRange("--max-waiting", max_waiting, 0, 100'000),
      CheckRange("--max-connections", max_connections, 1, 1'000'000),
      CheckRange("--max-connections-per-peer", max_connections_per_peer, 1, 1'000'000),
      CheckRange("--max-header-bytes", max_header_bytes, 1 << 10, 1 << 20),
      CheckAbove0("--stall-timeout", stall_timeout),
      CheckAbove0("--idle-timeout", idle_timeout),
      CheckAbove0("--handshake-timeout", handshake_timeout),
      CheckAbove0("keepalive_time", keepalive_time),
      CheckAbove0("keepalive_timeout", keepalive_timeout),
      CheckGoesWith("--tls-cert", tls_cert, "--tls-key", tls_key),
      CheckGoesWith("--tls-key", tls_key, "--tls-cert", tls_cert),
      CheckGoesWith("--tls-client-ca", tls_client_ca, "--tls-cert", tls_cert),
      CheckGoesWith("--tls-client-names", tls_client_names, "--tls-client-ca", tls_client_ca),
      CheckAddress("--listen", listen),
      CheckAddress("--health-listen", health_listen),
      CheckMetricsAddress(metrics_listen),
      CheckReach(*this),
  };
  for (const absl::Status& check : checks) {
    if (!check.ok()) return check;
  }
  if (drain_timeout < absl::ZeroDuration()) {
    return MakeError(absl::StatusCode::kInvalidArgument,
                     {kReasonInvalidOption, "--drain-timeout", absl::FormatDuration(drain_timeout), "at least 0s", {}});
  }
  return absl::OkStatus();
}

ServerOptions ServerOptions::Resolved() const {
  ServerOptions resolved = *this;
  if (threads == 0) resolved.threads = DetectProcessorCount();
  if (memory_limit_bytes == 0) resolved.memory_limit_bytes = DetectMemoryBytes() / 10 * 8;
  return resolved;
}

}  // namespace curvd
