#include "bench/threads.h"

#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "bench/stopwatch.h"

namespace curvd::bench {

Figures Spin(int threads) {
  constexpr int kSteps = 100'000'000;
  const double start = WallSeconds();
  std::vector<std::thread> workers;
  for (int t = 0; t < threads; ++t) {
    workers.emplace_back([threads] {
      volatile double x = 1.0;
      for (int i = 0; i < kSteps / threads; ++i) x = x * 1.0000001;
    });
  }
  for (std::thread& worker : workers) worker.join();
  const double wall = WallSeconds() - start;
  return {{"total", wall}, {"wall", wall}};
}

void AddSpeedup(const std::string& what, double speedup, double control, Targets& targets) {
  constexpr double kWanted = 1.85;
  if (control >= kWanted) {
    targets.AtLeast(what, kWanted, speedup, "x");
  } else {
    targets.NotMeasurable(what, absl::StrCat("at least ", kWanted, "x"),
                          absl::StrCat("two spinning threads gain ", Digits(control), "x here"));
  }
}

}  // namespace curvd::bench
