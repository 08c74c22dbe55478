// Holds what all calls of one server share.
#pragma once

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "core/job/worker_pool.h"
#include "server/access/access_control.h"
#include "server/admission/admission.h"
#include "server/admission/stream_gate.h"
#include "server/call/request_limits.h"
#include "server/net/connection_registry.h"
#include "server/observe/security_metrics.h"
#include "server/observe/server_log.h"
#include "server/observe/server_metrics.h"
#include "server/observe/stranger_log.h"
#include "server/rpc/request_ids.h"
#include "server/server_options.h"

namespace curvd {

// REQUIRES: all calls are done before this is destroyed. Thread-safe.
struct ServiceContext {
  // REQUIRES: `options` are valid, threads and memory_limit_bytes are not 0.
  explicit ServiceContext(const ServerOptions& options);
  ServiceContext(const ServiceContext&) = delete;
  ServiceContext& operator=(const ServiceContext&) = delete;

  ServerGauges gauges() const;
  // Who makes a call with these credentials and so much metadata, or the error of AccessControl::Identify; its
  // connection is told either way.
  absl::StatusOr<Caller> LetIn(const PresentedCredentials& presented, uint64_t metadata_bytes);

  const CallLimits limits;
  const absl::Duration stall_timeout;
  const size_t waiting_limit;  // calls that may wait for memory
  ServerLog log;
  SecurityMetrics security_metrics;
  StrangerLog strangers{security_metrics, log};
  RequestIds request_ids;
  AccessControl access;
  ConnectionRegistry connections;  // to the port that takes calls
  StreamGate gate;
  Admission admission;
  ServerMetrics metrics;
  WorkerPool pool;  // last: its threads may use all of the above until they are joined
};

}  // namespace curvd
