// Runs loops over many items on several threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

namespace curv {

// Calls run(begin, end) for ranges that cover [0, count) without overlap, on `threads` threads at once, or on as many
// as there are cores if `threads` is 0. Returns when all calls have. REQUIRES: run does not throw; threads >= 0.
template <typename Run>
void ParallelFor(size_t count, int threads, const Run& run) {
  constexpr size_t kRange = 4096;
  const size_t wanted = threads > 0 ? static_cast<size_t>(threads) : std::max(1u, std::thread::hardware_concurrency());
  std::atomic<size_t> next = 0;
  const auto work = [&] {
    for (size_t begin; (begin = next.fetch_add(kRange)) < count;) run(begin, std::min(count, begin + kRange));
  };
  std::vector<std::jthread> helpers;
  const size_t ranges = (count + kRange - 1) / kRange;
  for (size_t i = 1; i < std::min(wanted, ranges); ++i) helpers.emplace_back(work);
  work();
}

}  // namespace curv
