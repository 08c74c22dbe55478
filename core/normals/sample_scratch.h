// What the workers of a probe fit the points of samples with.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

namespace curvd {

// The scratch of each worker that looks at the few points of samples, of a type that derives from GroupScratch.
// Thread-safe for distinct workers.
template <typename Scratch>
class SampleScratch {
 public:
  explicit SampleScratch(int thread_count) : of_worker_(static_cast<size_t>(thread_count)) {}

  // Made when it is asked for first. No run ends between the points of a sample. May throw std::bad_alloc.
  Scratch& Of(int worker, const std::atomic<bool>& stopped) {
    std::unique_ptr<Scratch>& scratch = of_worker_[static_cast<size_t>(worker)];
    if (scratch == nullptr) {
      scratch = std::make_unique<Scratch>();
      scratch->most_work = std::numeric_limits<uint64_t>::max();  // a few points are no work
    }
    scratch->stopped = &stopped;
    return *scratch;
  }

 private:
  std::vector<std::unique_ptr<Scratch>> of_worker_;
};

}  // namespace curvd
