// A reusable, aligned buffer for kernels.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <new>
#include <type_traits>

namespace curvd {

// Grows, never shrinks. Aligned for any vector. Not thread-safe.
template <typename T>
class ScratchArray {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  // Makes room for `size` elements, keeping those there; new ones are uninitialized.
  void Reserve(size_t size) {
    if (size <= capacity_) return;
    const size_t capacity = std::max(size, capacity_ + capacity_ / 2);
    std::unique_ptr<T[], Free> grown(static_cast<T*>(::operator new(capacity * sizeof(T), kAlignment)));
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
  struct Free {
    void operator()(T* pointer) const { ::operator delete(pointer, kAlignment); }
  };

  size_t capacity_ = 0;
  std::unique_ptr<T[], Free> elements_;
};

}  // namespace curvd
