#include "server/host/memory_reuse.h"

#include <algorithm>
#include <chrono>

#include "core/base/page_pool.h"

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace curvd {

void ReuseFreedMemory(uint64_t memory_limit_bytes) {
  constexpr uint64_t kKeptShare = 8;
  constexpr uint64_t kKeptPageBytes = 128 << 20;
  constexpr uint64_t kKeptPageShare = 16;
  ProcessPages().SetLimits({.kept = std::min(kKeptPageBytes, memory_limit_bytes / kKeptPageShare),
                            .together = memory_limit_bytes - memory_limit_bytes / kKeptShare});
#ifdef __GLIBC__
  constexpr int kArenas = 2;  // each keeps as much
  constexpr uint64_t kKeptBytes = 64 << 20;
  constexpr uint64_t kLargestOnHeap = 32 << 20;  // glibc takes no more
  const uint64_t kept = std::min(kKeptBytes, memory_limit_bytes / kKeptShare / kArenas);
  mallopt(M_ARENA_MAX, kArenas);
  mallopt(M_TRIM_THRESHOLD, static_cast<int>(kept));
  mallopt(M_MMAP_THRESHOLD, static_cast<int>(std::min(kLargestOnHeap, kept)));
#endif
}

void ReturnUnusedPages() {
  constexpr auto kKeptFor = std::chrono::seconds(10);
  ProcessPages().Release(PagePool::Clock::now() - kKeptFor);
}

}  // namespace curvd
