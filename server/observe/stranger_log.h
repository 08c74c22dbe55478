// Counts and logs those who came without a call that was let in.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "server/observe/log_rate_limit.h"
#include "server/observe/security_metrics.h"
#include "server/observe/server_log.h"

namespace curvd {

// What is known of one who was turned away.
struct Stranger {
  StrangerReason reason;
  std::string peer;                        // as gRPC writes it; "" where nobody knows
  std::optional<double> seconds;           // how long the connection was open, if it was
  std::optional<uint64_t> received_bytes;  // what it sent
};

// Counts every one. Logs at most LogRateLimit::kLinesPerSecond of them, and the next line tells how many were left out;
// those that sent nothing are not logged, since load balancers look so whether a port is open. Thread-safe.
class StrangerLog {
 public:
  // Both must outlive this.
  StrangerLog(SecurityMetrics& metrics, ServerLog& log) : metrics_(metrics), log_(log) {}

  void Note(const Stranger& stranger);

 private:
  SecurityMetrics& metrics_;
  ServerLog& log_;
  LogRateLimit limit_;
};

}  // namespace curvd
