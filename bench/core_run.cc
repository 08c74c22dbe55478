#include "bench/core_run.h"

#include <cstdio>
#include <cstdlib>

#include "bench/stopwatch.h"
#include "core/job/estimation_job.h"
#include "core/scale/outliers/outlier_run.h"

namespace curvd::bench {

Figures RunCore(const BenchCloud& cloud, const EstimatorOptions& options, WorkerPool& pool, CurvatureField* field) {
  Cloud input = ToCloud(cloud);
  const double wall_start = WallSeconds(), cpu_start = CpuSeconds();
  auto result = EstimateCurvature(std::move(input), options, pool);
  const double cpu = CpuSeconds() - cpu_start, wall = WallSeconds() - wall_start;
  if (!result.ok()) {
    std::fprintf(stderr, "%s\n", result.status().ToString().c_str());
    std::exit(1);
  }
  // The job's own clock is the wall's; its proportions split the CPU time.
  const JobCost& cost = result->cost;
  const double cpu_per_wall = cpu / (*cost.seconds.index + *cost.seconds.estimate);
  const double build = cpu_per_wall * *cost.seconds.index;
  const double outliers = cpu_per_wall * SecondsOf(cost.phases, kOutlierPhase);
  if (field != nullptr) *field = std::move(result->field);
  return {{"total", cpu}, {"build", build}, {"query", cpu - build}, {"outliers", outliers}, {"wall", wall}};
}

EstimatorOptions OptionsFor(std::string_view estimator, uint32_t k, uint32_t rotations) {
  EstimatorOptions options;
  options.estimator = estimator;
  options.neighborhood = NeighborCount{k};
  options.rotation_count = rotations;
  return options;
}

}  // namespace curvd::bench
