// Queries of which a part is answered, where all would take minutes.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "bench/stopwatch.h"

namespace curvd::bench {

// Calls `answer(i)` for queries i in [0, count): for all, or for one run in `one_in` of 4,096 queries in a row, so that
// the caches see the same neighborhood of queries as they would in all. Returns the CPU seconds that all take, at the
// pace of those that were answered.
template <typename Answer>
double AnswerQueries(size_t count, size_t one_in, const Answer& answer) {
  constexpr size_t kRun = 4096;
  const double start = CpuSeconds();
  size_t answered = 0;
  for (size_t first = 0; first < count; first += kRun * one_in) {
    const size_t last = std::min(first + kRun, count);
    for (size_t i = first; i < last; ++i) answer(static_cast<uint32_t>(i));
    answered += last - first;
  }
  return (CpuSeconds() - start) * static_cast<double>(count) / static_cast<double>(answered);
}

}  // namespace curvd::bench
