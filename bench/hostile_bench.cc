// What clouds that are made to cost too much cost: CPU time of every estimator, in one thread, and how it grows.
//   hostile_bench [POINTS [CLOUD [ESTIMATOR]]]: the cloud and the estimator whose names contain the text.
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "bench/core_run.h"
#include "core/estimators/strategies.h"
#include "tests/core/hostile_clouds.h"

namespace curvd::bench {
namespace {

BenchCloud Make(const testing::HostileCloud& hostile, size_t points) {
  std::vector<std::array<float, 3>> positions, normals;
  hostile.make(points, positions, normals);
  BenchCloud cloud{.name = std::string(hostile.name), .positions = {}, .normals = {}, .true_mean = {}};
  for (const auto& v : positions) cloud.positions.insert(cloud.positions.end(), v.begin(), v.end());
  for (const auto& v : normals) cloud.normals.insert(cloud.normals.end(), v.begin(), v.end());
  return cloud;
}

double Seconds(const BenchCloud& cloud, std::string_view estimator, WorkerPool& pool) {
  return RunCore(cloud, OptionsFor(estimator, 50), pool)["total"];
}

bool Wanted(std::string_view name, int argc, char** argv, int argument) {
  return argc <= argument || name.find(argv[argument]) != std::string_view::npos;
}

void Main(int argc, char** argv) {
  const size_t points = argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 25'000;
  WorkerPool pool(1);
  std::printf("%-22s %-13s %9s s %9s s  ratio\n", "cloud", "estimator", std::to_string(points).c_str(),
              std::to_string(2 * points).c_str());
  for (const testing::HostileCloud& hostile : testing::HostileClouds()) {
    if (!Wanted(hostile.name, argc, argv, 2)) continue;
    const BenchCloud once = Make(hostile, points), twice = Make(hostile, 2 * points);
    for (const Strategy* strategy : Strategies()) {
      if (!Wanted(strategy->name, argc, argv, 3)) continue;
      const double first = Seconds(once, strategy->name, pool), second = Seconds(twice, strategy->name, pool);
      std::printf("%-22s %-13s %11.3f %11.3f %6.2f\n", once.name.c_str(), std::string(strategy->name).c_str(), first,
                  second, second / first);
      std::fflush(stdout);
    }
  }
}

}  // namespace
}  // namespace curvd::bench

int main(int argc, char** argv) { curvd::bench::Main(argc, argv); }
