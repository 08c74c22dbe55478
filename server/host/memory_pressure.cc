#include "server/host/memory_pressure.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace curvd {

uint64_t ResidentBytes() {
  static const int statm = open("/proc/self/statm", O_RDONLY | O_CLOEXEC);
  static const auto page = static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
  char text[128] = "";
  if (statm < 0 || pread(statm, text, sizeof(text) - 1, 0) <= 0) return 0;
  unsigned long long size = 0, resident = 0;
  return std::sscanf(text, "%llu %llu", &size, &resident) == 2 ? resident * page : 0;
}

MemoryPressure::Level MemoryPressure::Judge(uint64_t resident_bytes) const {
  const uint64_t normal = limit_ + expected_;
  if (resident_bytes > normal + kCriticalBytes) return Level::kCritical;
  return resident_bytes > normal + kHighBytes ? Level::kHigh : Level::kFine;
}

uint64_t MemoryPressure::Headroom(uint64_t resident_bytes) const {
  const uint64_t most = limit_ + expected_ + kHighBytes;
  return most - std::min(most, resident_bytes);
}

void MemoryPressure::NoteFreed(Clock::time_point now) { freed_at_ = now.time_since_epoch().count(); }

void MemoryPressure::Tick(Clock::time_point now) {
  // gRPC frees what a connection held some time after it has ended.
  constexpr auto kFreesFor = std::chrono::seconds(5);
  const Clock::rep freed_at = freed_at_;
  if (freed_at == 0 || now - Clock::time_point(Clock::duration(freed_at)) > kFreesFor) return;
  Trim(now);
}

bool MemoryPressure::Trim(Clock::time_point now) {
  Clock::rep last = trimmed_at_;
  if (last != 0 && now - Clock::time_point(Clock::duration(last)) < kTrimInterval) return false;
  if (!trimmed_at_.compare_exchange_strong(last, now.time_since_epoch().count())) return false;
#ifdef __GLIBC__
  malloc_trim(0);
#endif
  return true;
}

}  // namespace curvd
