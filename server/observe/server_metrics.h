// Counts what Prometheus scrapes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "server/rpc/call_record.h"
#include "server/rpc/rpc_method.h"

namespace prometheus {
class Collectable;
}  // namespace prometheus

namespace curvd {

// The state of the server at the moment of a scrape.
struct ServerGauges {
  size_t jobs_waiting_for_memory = 0;
  size_t jobs_waiting_for_workers = 0;
  size_t waiting_limit = 0;  // calls that may wait for memory
  size_t workers = 0;
  size_t workers_busy = 0;
  uint64_t memory_reserved_bytes = 0;
  uint64_t memory_limit_bytes = 0;
  size_t streams_open = 0;
  size_t streams_limit = 0;
  bool draining = false;
  uint64_t log_lines_lost = 0;
};

// Every label value is one of a fixed set, never one that a caller chose, and all series exist from the start.
// Thread-safe.
class ServerMetrics {
 public:
  // `read_gauges` is called at each scrape, on any thread, as long as somebody holds collectables().
  explicit ServerMetrics(std::function<ServerGauges()> read_gauges);
  ~ServerMetrics();

  void CountStarted(RpcMethod method);
  void CountReceived(RpcMethod method, uint64_t bytes);
  void CountSent(RpcMethod method, uint64_t bytes);
  void CountHandled(RpcMethod method, absl::StatusCode code, double seconds);
  // The rest of what the record of an RPC tells: the reason of a failure, and of an EstimateCurvature points and
  // phases.
  void CountCall(const CallRecord& record);

  // What to register with an exposer.
  const std::vector<std::shared_ptr<prometheus::Collectable>>& collectables() const;

 private:
  struct Families;
  std::unique_ptr<Families> families_;
};

}  // namespace curvd
