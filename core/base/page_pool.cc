#include "core/base/page_pool.h"

#include <sys/mman.h>

#include <algorithm>
#include <bit>

namespace curvd {
namespace {

constexpr size_t kPageBytes = 4096;
constexpr size_t kMostRanges =
    256;  // that are kept at most: a call leaves those of five arrays, and of its large buffers
constexpr size_t kHugePageBytes = size_t{2} << 20;

// Rounded up to one of 32 sizes between a power of two and the next, so that arrays for clouds of nearly the same size
// find each other's pages.
size_t RangeBytes(size_t bytes) {
  const size_t step = std::max(kPageBytes, std::bit_floor(bytes) / 32);
  return (bytes + step - 1) / step * step;
}

void UnmapRange(void* pages, size_t bytes) { (void)munmap(pages, bytes); }

void* MapRange(size_t bytes) {
  // What shall be left is asked for as well, and given back at once.
  constexpr size_t kSpare = PagePool::kLeftToOthers;
  void* spare = mmap(nullptr, kSpare + bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (spare == MAP_FAILED) return nullptr;
  UnmapRange(spare, kSpare);
  void* pages = static_cast<char*>(spare) + kSpare;
  // Random access to points misses the TLB on small pages; a refusal costs speed alone.
  if (bytes >= kHugePageBytes) (void)madvise(pages, bytes, MADV_HUGEPAGE);
  return pages;
}

}  // namespace

PagePool::~PagePool() { SetLimits({}); }

void* PagePool::Map(size_t bytes) {
  bytes = RangeBytes(bytes);
  {
    MutexLock lock(mutex_);
    if (void* pages = TakeKept(bytes); pages != nullptr) {
      used_bytes_ += bytes;
      return pages;
    }
  }
  return MapNew(bytes);
}

void* PagePool::MapFresh(size_t bytes) { return MapNew(RangeBytes(bytes)); }

void* PagePool::MapNew(size_t bytes) {
  {
    MutexLock lock(mutex_);
    used_bytes_ += bytes;
    ReturnSurplus();
  }
  if (void* pages = MapRange(bytes); pages != nullptr) return pages;
  Release(Clock::time_point::max());
  void* pages = MapRange(bytes);
  if (pages == nullptr) {
    MutexLock lock(mutex_);
    used_bytes_ -= bytes;
  }
  return pages;
}

bool PagePool::HasRoomFor(size_t bytes) {
  const auto probe = [bytes] {
    void* pages = mmap(nullptr, kLeftToOthers + bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (pages == MAP_FAILED) return false;
    UnmapRange(pages, kLeftToOthers + bytes);
    return true;
  };
  if (probe()) return true;
  Release(Clock::time_point::max());
  return probe();
}

void PagePool::UnmapFresh(void* pages, size_t bytes) {
  bytes = RangeBytes(bytes);
  UnmapRange(pages, bytes);
  MutexLock lock(mutex_);
  used_bytes_ -= bytes;
}

void PagePool::Unmap(void* pages, size_t bytes) {
  bytes = RangeBytes(bytes);
  MutexLock lock(mutex_);
  used_bytes_ -= bytes;
  if (bytes > limits_.kept) return UnmapRange(pages, bytes);
  if (kept_.size() == kMostRanges) ReturnOldest();
  kept_.push_back({pages, bytes, Clock::now()});
  kept_bytes_ += bytes;
  ReturnSurplus();
}

void PagePool::SetLimits(const Limits& limits) {
  MutexLock lock(mutex_);
  limits_ = limits;
  kept_.reserve(kMostRanges);
  ReturnSurplus();
}

void PagePool::Release(Clock::time_point time) {
  MutexLock lock(mutex_);
  while (!kept_.empty() && kept_.front().unused_since < time) ReturnOldest();
}

size_t PagePool::kept_bytes() const {
  MutexLock lock(mutex_);
  return kept_bytes_;
}

void* PagePool::TakeKept(size_t bytes) {
  const auto found =
      std::find_if(kept_.rbegin(), kept_.rend(), [bytes](const Range& range) { return range.bytes == bytes; });
  if (found == kept_.rend()) return nullptr;
  void* pages = found->pages;
  kept_bytes_ -= bytes;
  kept_.erase(std::next(found).base());
  return pages;
}

void PagePool::ReturnOldest() {
  const Range oldest = kept_.front();
  kept_bytes_ -= oldest.bytes;
  kept_.erase(kept_.begin());
  UnmapRange(oldest.pages, oldest.bytes);
}

void PagePool::ReturnSurplus() {
  while (kept_bytes_ > 0 && (kept_bytes_ > limits_.kept || used_bytes_ + kept_bytes_ > limits_.together)) {
    ReturnOldest();
  }
}

PagePool& ProcessPages() {
  static PagePool& pool = *new PagePool;  // arrays may outlive every static object
  return pool;
}

}  // namespace curvd
