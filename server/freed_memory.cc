#include "server/freed_memory.h"

#include <algorithm>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace curvd {

void KeepFreedBuffers(uint64_t memory_limit_bytes) {
#ifdef __GLIBC__
  constexpr int kArenas = 2;  // each keeps as much
  constexpr uint64_t kKeptBytes = 64 << 20;
  constexpr uint64_t kKeptShare = 8;
  constexpr uint64_t kLargestOnHeap = 32 << 20;  // glibc takes no more
  const uint64_t kept = std::min(kKeptBytes, memory_limit_bytes / kKeptShare / kArenas);
  mallopt(M_ARENA_MAX, kArenas);
  mallopt(M_TRIM_THRESHOLD, static_cast<int>(kept));
  mallopt(M_MMAP_THRESHOLD, static_cast<int>(std::min(kLargestOnHeap, kept)));
#else
  (void)memory_limit_bytes;
#endif
}

}  // namespace curvd
