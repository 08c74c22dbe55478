// A reusable, aligned buffer for kernels.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>

#include "core/base/page_pool.h"

namespace curvd {

// Grows, never shrinks; one that was moved from is empty. Aligned for any vector. Not thread-safe.
//
// Buffers of kLargeBytes and more are ranges of ProcessPages(), which leaves address space to the libraries that end
// the process when they get none: how large a buffer becomes is often for a caller to decide. Such a range may be a
// kept one, and is kept when the buffer dies, as those of arrays of points are. Smaller buffers come from operator new.
// While a buffer grows, its old and its new memory are held at once.
template <typename T>
class ScratchArray {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  ScratchArray() = default;
  ScratchArray(ScratchArray&& other) noexcept
      : capacity_(std::exchange(other.capacity_, 0)), elements_(std::move(other.elements_)) {}
  ScratchArray& operator=(ScratchArray&& other) noexcept {
    capacity_ = std::exchange(other.capacity_, 0);
    elements_ = std::move(other.elements_);
    return *this;
  }
  static constexpr size_t kLargeBytes = size_t{64} << 10;

  // Makes room for `size` elements, keeping those there; new ones are uninitialized. Throws std::bad_alloc, and leaves
  // the buffer as it was, if the system gives no memory.
  void Reserve(size_t size) {
    if (size <= capacity_) return;
    const size_t capacity = std::max(size, capacity_ + capacity_ / 2);
    std::unique_ptr<T[], Free> grown(static_cast<T*>(Allocate(capacity * sizeof(T))), Free{capacity * sizeof(T)});
    std::copy(elements_.get(), elements_.get() + capacity_, grown.get());
    elements_ = std::move(grown);
    capacity_ = capacity;
  }
  size_t capacity() const { return capacity_; }
  size_t bytes() const { return capacity_ * sizeof(T); }
  // Bytes that an array holds at most for which no more than `size` elements were ever reserved.
  static constexpr size_t MostBytes(size_t size) { return (size + size / 2) * sizeof(T); }
  T* data() { return elements_.get(); }
  const T* data() const { return elements_.get(); }
  T& operator[](size_t i) { return elements_[i]; }
  const T& operator[](size_t i) const { return elements_[i]; }

 private:
  static constexpr std::align_val_t kAlignment{64};

  static void* Allocate(size_t bytes) {
    if (bytes < kLargeBytes) return ::operator new(bytes, kAlignment);
    void* pages = ProcessPages().Map(bytes);
    if (pages == nullptr) throw std::bad_alloc();
    return pages;
  }
  struct Free {
    size_t bytes = 0;
    void operator()(T* pointer) const {
      if (bytes < kLargeBytes) return ::operator delete(pointer, kAlignment);
      ProcessPages().Unmap(pointer, bytes);
    }
  };

  size_t capacity_ = 0;
  std::unique_ptr<T[], Free> elements_;
};

}  // namespace curvd
