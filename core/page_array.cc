#include "core/page_array.h"

#include <sys/mman.h>

namespace curvd::internal {
namespace {
constexpr size_t kHugePageBytes = size_t{2} << 20;
}  // namespace

void* MapPages(size_t bytes) {
  void* pages = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (pages == MAP_FAILED) return nullptr;
  // Random access to points misses the TLB on small pages; a refusal costs speed alone.
  if (bytes >= kHugePageBytes) (void)madvise(pages, bytes, MADV_HUGEPAGE);
  return pages;
}

void UnmapPages(void* pages, size_t bytes) { (void)munmap(pages, bytes); }

}  // namespace curvd::internal
