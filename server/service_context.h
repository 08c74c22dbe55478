// What all calls of one server share.
#pragma once

#include "absl/time/time.h"
#include "core/worker_pool.h"
#include "server/access_control.h"
#include "server/admission.h"
#include "server/call_limits.h"
#include "server/request_ids.h"
#include "server/security_metrics.h"
#include "server/server_log.h"
#include "server/server_metrics.h"
#include "server/server_options.h"
#include "server/stranger_log.h"
#include "server/stream_gate.h"

namespace curvd {

// REQUIRES: all calls are done before this is destroyed. Thread-safe.
struct ServiceContext {
  // REQUIRES: `options` are valid, threads and memory_limit_bytes are not 0.
  explicit ServiceContext(const ServerOptions& options);
  ServiceContext(const ServiceContext&) = delete;
  ServiceContext& operator=(const ServiceContext&) = delete;

  ServerGauges gauges() const;

  const CallLimits limits;
  const absl::Duration stall_timeout;
  const size_t waiting_limit;  // calls that may wait for memory
  ServerLog log;
  SecurityMetrics security_metrics;
  StrangerLog strangers{security_metrics, log};
  RequestIds request_ids;
  AccessControl access;
  StreamGate gate;
  Admission admission;
  ServerMetrics metrics;
  WorkerPool pool;  // last: its threads may use all of the above until they are joined
};

}  // namespace curvd
