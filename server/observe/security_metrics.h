// Counts strangers, connections and credentials for Prometheus.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "absl/time/time.h"

namespace prometheus {
class Collectable;
}  // namespace prometheus

namespace curvd {

// Why a connection was closed at once, or why it was a stranger's when it ended. The names of the values are those of
// the label `reason`.
enum class StrangerReason {
  kConnectionLimit,      // connection_limit: --max-connections are open
  kPeerConnectionLimit,  // peer_connection_limit: --max-connections-per-peer are open from this address
  kNoDescriptor,         // no_descriptor: the system has none left
  kHandshakeTimeout,     // handshake_timeout: it ended when --handshake-timeout was over, without a call
  kNothingSent,          // nothing_sent: it ended before it had sent a byte, as that of a load balancer that looks
  kNoCall,               // no_call: it sent something, and ended without a call
  kNotLetIn,             // not_let_in: access control let none of its calls in
  kUnaccountedBytes,     // unaccounted_bytes: it was ended, as it had sent more than its calls account for
  kTooMuchMetadata,      // too_much_metadata: it was ended, as a call had more metadata than gRPC should let through
  kMemoryShort,          // memory_short: it was ended, or not taken, as the process had too much memory
};
inline constexpr size_t kStrangerReasonCount = static_cast<size_t>(StrangerReason::kMemoryShort) + 1;
const char* StrangerReasonName(StrangerReason reason);

// All series exist from the start. Thread-safe.
class SecurityMetrics {
 public:
  SecurityMetrics();
  ~SecurityMetrics();

  void CountStranger(StrangerReason reason);
  void CountReload(bool ok);
  void SetCertificateExpiry(absl::Time expires);
  // `open` is called at each scrape, until it is replaced.
  void ReadConnectionsFrom(std::function<size_t()> open);

  // What to register with an exposer.
  const std::vector<std::shared_ptr<prometheus::Collectable>>& collectables() const;

 private:
  struct Families;
  std::unique_ptr<Families> families_;
};

}  // namespace curvd
