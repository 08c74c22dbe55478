// Asked between the slices of long work: whether anybody still wants it.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <limits>

namespace curvd {

// What somebody who counts is told of the slices of a work, of one thread. For tests: what is promised is that slices
// are small, and that none begins after a stop.
struct SliceLog {
  size_t stop_before = std::numeric_limits<size_t>::max();  // the slice, counted from 0, before which the work stops
  size_t slices = 0;                                        // that were asked for
  size_t largest = 0;                                       // of those that went on, in records
  size_t records = 0;                                       // of all of them
};

// Copied freely; thread-safe where there is no log.
class StopSign {
 public:
  // Never stops anything.
  StopSign() = default;
  // Stops once *flag is true. REQUIRES: `flag` and `log` outlive all copies; each may be null.
  explicit StopSign(const std::atomic<bool>* flag, SliceLog* log = nullptr) : flag_(flag), log_(log) {}

  // Whether the work is to end before a slice of so many records.
  bool IsSetBefore(size_t records) const {
    if (log_ != nullptr) return StopsBefore(records);
    return flag_ != nullptr && flag_->load(std::memory_order_relaxed);
  }

 private:
  bool StopsBefore(size_t records) const {
    if (log_->slices++ >= log_->stop_before) return true;
    log_->largest = std::max(log_->largest, records);
    log_->records += records;
    return false;
  }

  const std::atomic<bool>* flag_ = nullptr;
  SliceLog* log_ = nullptr;
};

}  // namespace curvd
