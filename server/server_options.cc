#include "server/server_options.h"

#include <algorithm>
#include <string>
#include <thread>

#include "absl/strings/str_cat.h"
#include "server/error_detail.h"
#include "server/memory_limit.h"
#include "server/reasons.h"

namespace curvd {
namespace {

absl::Status CheckRange(const char* flag, uint64_t value, uint64_t low, uint64_t high) {
  if (value >= low && value <= high) return absl::OkStatus();
  return MakeError(absl::StatusCode::kInvalidArgument,
                   {kReasonInvalidOption, flag, absl::StrCat(value), absl::StrCat("in [", low, ", ", high, "]"), {}});
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
      CheckRange("--max-waiting", max_waiting, 0, 100'000),
  };
  for (const absl::Status& check : checks) {
    if (!check.ok()) return check;
  }
  if (drain_timeout < absl::ZeroDuration()) {
    return MakeError(absl::StatusCode::kInvalidArgument,
                     {kReasonInvalidOption, "--drain-timeout", absl::FormatDuration(drain_timeout), "at least 0s", {}});
  }
  if (stall_timeout <= absl::ZeroDuration()) {
    return MakeError(absl::StatusCode::kInvalidArgument,
                     {kReasonInvalidOption, "--stall-timeout", absl::FormatDuration(stall_timeout), "above 0s", {}});
  }
  return absl::OkStatus();
}

ServerOptions ServerOptions::Resolved() const {
  ServerOptions resolved = *this;
  if (threads == 0) resolved.threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  if (memory_limit_bytes == 0) resolved.memory_limit_bytes = DetectMemoryBytes() / 10 * 8;
  return resolved;
}

}  // namespace curvd
