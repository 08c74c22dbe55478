// How much memory a call may take, and whose turn it is to take it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string_view>

#include "absl/status/statusor.h"
#include "server/admission/memory_budget.h"
#include "server/call/header_options.h"

namespace curvd {

// Splits the server's memory into two lanes, in each of which callers take turns: an eighth serves small calls alone,
// so that they never wait behind large ones. A call whose size is unknown is large. Thread-safe.
class Admission {
 public:
  static constexpr size_t kLanes = 2;

  // At most `max_waiting` calls wait for memory in each lane. `thread_count` workers estimate.
  Admission(uint64_t memory_bytes, uint64_t max_chunk_bytes, size_t max_waiting, int thread_count);

  // Bytes that a call with `points` points holds at its peak: cloud, index, what normals and their orientation take,
  // results, the workers' scratch and messages in flight. `more_may_follow`: another chunk may be on its way, and be
  // larger than what was sent so far.
  uint64_t CallBytes(uint64_t points, const CallOptions& options, bool more_may_follow) const;
  // Bytes that it holds while it sends its results.
  uint64_t SendingBytes(uint64_t points, const CallOptions& options) const;

  // An empty reservation in the lane for a call with options.point_count points (0: unknown). RESOURCE_EXHAUSTED if it
  // could never be granted. `caller` stands for whose call it is (TurnKey). The reservation must not outlive this
  // object.
  absl::StatusOr<std::unique_ptr<MemoryBudget::Reservation>> Enter(const CallOptions& options, uint64_t caller);
  // To be called now and then: serves those who wait and may go now that time has gone by.
  void Tick() {
    small_.Tick();
    large_.Tick();
  }

  uint64_t limit() const { return small_.limit() + large_.limit(); }
  uint64_t reserved() const { return small_.reserved() + large_.reserved(); }
  size_t waiting() const { return small_.waiting() + large_.waiting(); }

 private:
  const uint64_t max_chunk_bytes_;
  const int thread_count_;
  MemoryBudget small_;
  MemoryBudget large_;
};

}  // namespace curvd
