#include "tests/core/failing_new.h"

#include <atomic>
#include <cstdlib>
#include <new>

namespace curvd::testing {
namespace {

constinit std::atomic<bool> active = false;
constinit std::atomic<bool> fails_all = false;
constinit std::atomic<ptrdiff_t> left = 0;  // allocations that succeed
constinit std::atomic<bool> failed = false;
constinit std::atomic<ptrdiff_t> live = 0;

bool Fails() {
  if (!active) return false;
  const ptrdiff_t before = left.fetch_sub(1);
  if (before > 0 || (before < 0 && !fails_all)) return false;
  failed = true;
  return true;
}

void* Count(void* memory) {
  if (memory != nullptr) ++live;
  return memory;
}

void* ThrowIfNull(void* memory) {
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

void* Allocate(size_t bytes) { return Count(Fails() ? nullptr : std::malloc(bytes)); }

void Free(void* memory) {
  if (memory == nullptr) return;
  --live;
  std::free(memory);
}

}  // namespace

FailingNew::FailingNew(size_t first, Failing failing) {
  left = static_cast<ptrdiff_t>(first);
  fails_all = failing == Failing::kAllFromThere;
  failed = false;
  active = true;
}

void FailingNew::Stop() { active = false; }

bool FailingNew::has_failed() const { return failed; }

ptrdiff_t LiveAllocations() { return live; }

}  // namespace curvd::testing

using curvd::testing::Allocate;
using curvd::testing::Count;
using curvd::testing::Fails;
using curvd::testing::Free;
using curvd::testing::ThrowIfNull;

// The other forms of new and delete call these. A form that throws nothing has its own, since a sanitizer's would not
// call the one that throws.
void* operator new(size_t bytes) { return ThrowIfNull(Allocate(bytes)); }
void* operator new(size_t bytes, const std::nothrow_t&) noexcept { return Allocate(bytes); }
void* operator new(size_t bytes, std::align_val_t alignment) {
  const auto step = static_cast<size_t>(alignment);
  return ThrowIfNull(Count(Fails() ? nullptr : std::aligned_alloc(step, (bytes + step - 1) / step * step)));
}
void operator delete(void* memory) noexcept { Free(memory); }
void operator delete(void* memory, size_t) noexcept { Free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { Free(memory); }
void operator delete(void* memory, size_t, std::align_val_t) noexcept { Free(memory); }
