// What Prometheus learns of strangers, connections and credentials.
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

// Why a connection or a request never became a call. The names of the values are those of the label `reason`.
enum class StrangerReason {
  kConnectionLimit,      // connection_limit: --max-connections are open
  kPeerConnectionLimit,  // peer_connection_limit: --max-connections-per-peer are open from this address
  kNoDescriptor,         // no_descriptor: the system has none left
  kNoCertificate,        // no_certificate: the client showed none
  kBadCertificate,       // bad_certificate: expired, or of an authority that is not trusted
  kPlainText,            // plain_text: no TLS on a TLS port
  kHandshakeTimeout,     // handshake_timeout: connected and said too little
  kHandshakeFailed,      // handshake_failed: any other end of a handshake
  kHeaderTooLarge,       // header_too_large: metadata over --max-header-bytes
};
inline constexpr size_t kStrangerReasonCount = static_cast<size_t>(StrangerReason::kHeaderTooLarge) + 1;
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
