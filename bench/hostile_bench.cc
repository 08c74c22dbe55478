// What clouds that are made to cost too much cost: CPU time of every estimator, in one thread, and how it grows.
//   hostile_bench [POINTS [CLOUD [ESTIMATOR]]]
#include <CLI/CLI.hpp>
#include <array>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

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

struct Flags {
  size_t points = 25'000;
  std::string cloud, estimator;  // empty: all
};

void Run(const Flags& flags) {
  WorkerPool pool(1);
  std::printf("%-22s %-13s %9s s %9s s  ratio\n", "cloud", "estimator", std::to_string(flags.points).c_str(),
              std::to_string(2 * flags.points).c_str());
  for (const testing::HostileCloud& hostile : testing::HostileClouds()) {
    if (!flags.cloud.empty() && flags.cloud != hostile.name) continue;
    const BenchCloud once = Make(hostile, flags.points), twice = Make(hostile, 2 * flags.points);
    for (const Strategy* strategy : Strategies()) {
      if (!flags.estimator.empty() && flags.estimator != strategy->name) continue;
      const double first = Seconds(once, strategy->name, pool), second = Seconds(twice, strategy->name, pool);
      std::printf("%-22s %-13s %11.3f %11.3f %6.2f\n", once.name.c_str(), std::string(strategy->name).c_str(), first,
                  second, second / first);
      std::fflush(stdout);
    }
  }
}

int Main(int argc, char** argv) {
  std::vector<std::string> clouds, estimators;
  for (const testing::HostileCloud& hostile : testing::HostileClouds()) clouds.emplace_back(hostile.name);
  for (const Strategy* strategy : Strategies()) estimators.emplace_back(strategy->name);
  Flags flags;
  CLI::App app("What clouds that are made to cost too much cost", "hostile_bench");
  app.add_option("points", flags.points)->check(CLI::Range(1, 10'000'000))->capture_default_str();
  app.add_option("cloud", flags.cloud, "one cloud; all unless given")->check(CLI::IsMember(clouds));
  app.add_option("estimator", flags.estimator, "one estimator; all unless given")->check(CLI::IsMember(estimators));
  CLI11_PARSE(app, argc, argv);
  Run(flags);
  return 0;
}

}  // namespace
}  // namespace curvd::bench

int main(int argc, char** argv) { return curvd::bench::Main(argc, argv); }
