#include "server/service_context.h"

namespace curvd {
namespace {

ByteAllowances AllowancesFor(const ServerOptions& options) {
  ByteAllowances allowances;
  allowances.max_message = options.max_message_bytes();
  allowances.max_metadata = options.max_header_bytes;
  allowances.stranger = ByteAllowances::ForMetadata(options.max_header_bytes);
  return allowances;
}

}  // namespace

ServiceContext::ServiceContext(const ServerOptions& options)
    : limits{options.max_points, options.max_chunk_bytes, options.max_neighbor_count, options.memory_limit_bytes,
             options.max_streams},
      stall_timeout(options.stall_timeout),
      waiting_limit(Admission::kLanes * options.max_waiting),
      log(options.log),
      connections(AllowancesFor(options)),
      gate(options.max_streams, options.max_streams_per_peer),
      admission(options.memory_limit_bytes, options.max_chunk_bytes, options.max_waiting, options.threads),
      metrics([this] { return gauges(); }),
      pool(options.threads) {}

absl::StatusOr<Caller> ServiceContext::LetIn(const PresentedCredentials& presented, uint64_t metadata_bytes) {
  absl::StatusOr<Caller> caller = access.Identify(presented);
  connections.NoteCall(presented.peer,
                       caller.ok() ? ConnectionRegistry::Call::kLetIn : ConnectionRegistry::Call::kRefused,
                       metadata_bytes);
  return caller;
}

ServerGauges ServiceContext::gauges() const {
  ServerGauges gauges;
  gauges.jobs_waiting_for_memory = admission.waiting();
  gauges.jobs_waiting_for_workers = pool.waiting_count();
  gauges.waiting_limit = waiting_limit;
  gauges.workers = static_cast<size_t>(pool.thread_count());
  gauges.workers_busy = static_cast<size_t>(pool.busy_count());
  gauges.memory_reserved_bytes = admission.reserved();
  gauges.memory_limit_bytes = admission.limit();
  gauges.streams_open = gate.open_count();
  gauges.streams_limit = limits.max_streams;
  gauges.draining = gate.draining();
  gauges.log_lines_lost = log.lines_lost();
  return gauges;
}

}  // namespace curvd
