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
  if (resident_bytes > limit_ + kCriticalBytes) return Level::kCritical;
  return resident_bytes > limit_ + kHighBytes ? Level::kHigh : Level::kFine;
}

uint64_t MemoryPressure::Headroom(uint64_t resident_bytes) const {
  const uint64_t most = limit_ + kHighBytes;
  return most - std::min(most, resident_bytes);
}

void MemoryPressure::NoteFreed(Clock::time_point now) { freed_at_ = now.time_since_epoch().count(); }

void MemoryPressure::Tick(Clock::time_point now) {
  // gRPC frees what a connection held some time after it has ended.
  constexpr auto kFreesFor = std::chrono::seconds(5);
  constexpr auto kInterval = std::chrono::seconds(1);
  const Clock::rep freed_at = freed_at_;
  if (freed_at == 0 || now - Clock::time_point(Clock::duration(freed_at)) > kFreesFor) return;
  if (now - trimmed_at_ < kInterval) return;
  trimmed_at_ = now;
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

}  // namespace curvd
