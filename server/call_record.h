// What is known about a call when it is over: for its log line and the metrics.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "core/curvature_field.h"

namespace curvd {

// Wall-clock seconds of each phase; 0 where the call never came to it.
struct PhaseTimes {
  double receive = 0.0;  // header to half-close, without `admit`
  double admit = 0.0;    // waiting for memory
  double queue = 0.0;    // waiting for a worker
  double index = 0.0;
  double estimate = 0.0;
  double send = 0.0;  // first result to summary
};

struct CallRecord {
  std::string request_id;
  std::string peer;
  std::string caller;  // who was let in; empty if nobody was
  std::string request_tag;
  absl::Status status;
  uint64_t points_received = 0;
  std::array<uint64_t, kPointStatusEnd> status_counts{};  // of a call that was estimated
  uint64_t normals_rescaled = 0;
  uint64_t messages_received = 0;
  uint64_t bytes_received = 0;
  uint64_t messages_sent = 0;
  uint64_t bytes_sent = 0;
  uint64_t peak_bytes = 0;
  double total_seconds = 0.0;
  PhaseTimes seconds;
};

}  // namespace curvd
