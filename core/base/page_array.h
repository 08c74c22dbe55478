// A fixed-size array of trivial values in its own memory pages.
//
// Arrays of many million points come and go with every call; pages that are mapped for one array alone can go back to
// the system when it dies, or to the next array (core/base/page_pool.h), and large ones ask for huge pages.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>

#include "absl/status/statusor.h"
#include "core/base/error.h"
#include "core/base/page_pool.h"

namespace curvd {

enum class PageUse : uint8_t {
  kWhole,   // every element will be written: pages may be kept ones, which take memory already
  kSparse,  // maybe a few: pages come from the system, which gives memory to those that are written
};

// Movable, not copyable. Thread-compatible: const methods may run concurrently, distinct elements may be written
// concurrently.
template <typename T>
class PageArray {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);

 public:
  PageArray() = default;
  // Returns `size` elements with any values, or kOutOfMemory (core/base/error.h) if the system has
  // no memory for them.
  static absl::StatusOr<PageArray> Create(size_t size, PageUse use = PageUse::kWhole) {
    PageArray array;
    if (size == 0) return array;
    array.use_ = use;
    const size_t bytes = size * sizeof(T);
    void* pages = use == PageUse::kWhole ? ProcessPages().Map(bytes) : ProcessPages().MapFresh(bytes);
    if (pages == nullptr)
      return MakeCoreError(ErrorKind::kOutOfMemory, "out of memory: no pages for an array of points");
    array.elements_ = static_cast<T*>(pages);
    array.size_ = size;
    return array;
  }
  PageArray(PageArray&& other) noexcept
      : elements_(std::exchange(other.elements_, nullptr)), size_(std::exchange(other.size_, 0)), use_(other.use_) {}
  PageArray& operator=(PageArray&& other) noexcept {
    std::swap(elements_, other.elements_);
    std::swap(size_, other.size_);
    std::swap(use_, other.use_);
    return *this;
  }
  ~PageArray() {
    if (elements_ == nullptr) return;
    use_ == PageUse::kWhole ? ProcessPages().Unmap(elements_, bytes()) : ProcessPages().UnmapFresh(elements_, bytes());
  }

  // The same bytes as elements of another type; this array is then empty. REQUIRES: they make whole elements, aligned
  // to a page at most.
  template <typename U>
  PageArray<U> Recast() && {
    PageArray<U> array;
    array.size_ = bytes() / sizeof(U);
    array.elements_ = reinterpret_cast<U*>(std::exchange(elements_, nullptr));
    array.use_ = use_;
    size_ = 0;
    return array;
  }

  T* data() { return elements_; }
  const T* data() const { return elements_; }
  size_t size() const { return size_; }
  size_t bytes() const { return size_ * sizeof(T); }
  T& operator[](size_t i) { return elements_[i]; }
  const T& operator[](size_t i) const { return elements_[i]; }
  std::span<const T> span() const { return {elements_, size_}; }

 private:
  template <typename U>
  friend class PageArray;

  T* elements_ = nullptr;
  size_t size_ = 0;
  PageUse use_ = PageUse::kWhole;
};

}  // namespace curvd
