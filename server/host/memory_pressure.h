// Tells whether the process has more memory than it should, and gives back what was freed.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

namespace curvd {

// Bytes of memory that the process has now, as the system counts them; 0 if it does not tell. Takes microseconds.
uint64_t ResidentBytes();

// The memory limit is what calls reserve. What a process has beside: its code and threads, about 30 MiB; what it freed
// and keeps, which Trim gives back; what it expects calls to hold that wait (Expect); and what gRPC holds for bytes
// that no call accounts for, which should be little. Thread-safe.
class MemoryPressure {
 public:
  using Clock = std::chrono::steady_clock;

  // How much the process has beside the limit and what it expects.
  enum class Level {
    kFine,
    kHigh,      // more than kHighBytes: whoever has nothing to lose should go
    kCritical,  // more than kCriticalBytes: whoever is not known to be good should go, and nobody else come
  };
  static constexpr uint64_t kHighBytes = 32 << 20;
  static constexpr uint64_t kCriticalBytes = 48 << 20;

  // The limit of a process whose memory does not matter.
  static constexpr uint64_t kAnyLimit = uint64_t{1} << 60;

  explicit MemoryPressure(uint64_t memory_limit_bytes) : limit_(memory_limit_bytes) {}

  // From now on calls hold so many bytes that are not reserved, as they should: those that wait for memory. DEFAULT: 0.
  void Expect(uint64_t unreserved_bytes) { expected_ = unreserved_bytes; }
  Level Judge(uint64_t resident_bytes) const;
  // How much more the process may have until that is kHigh.
  uint64_t Headroom(uint64_t resident_bytes) const;
  // Memory was freed, or will be soon, that should go back to the system.
  void NoteFreed(Clock::time_point now);
  // Gives freed memory back, once a second in the seconds after NoteFreed. Takes milliseconds then.
  void Tick(Clock::time_point now);
  // Gives freed memory back now, unless that was done less than kTrimInterval ago. Returns whether it did; what the
  // process has then shows when it is asked again. Takes milliseconds.
  bool Trim(Clock::time_point now);
  static constexpr std::chrono::seconds kTrimInterval{1};

 private:
  const uint64_t limit_;
  std::atomic<uint64_t> expected_{0};
  std::atomic<Clock::rep> freed_at_{0};  // 0: not yet
  std::atomic<Clock::rep> trimmed_at_{0};
};

}  // namespace curvd
