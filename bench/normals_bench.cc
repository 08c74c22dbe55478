// Normals from positions alone: what they cost, how exact they are, and what curvature is worth with them.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "bench/clouds.h"
#include "bench/flags.h"
#include "bench/stopwatch.h"
#include "bench/table.h"
#include "client/surfaces/noise.h"
#include "core/job/estimation_job.h"
#include "core/job/normals_job.h"

namespace curvd::bench {
namespace {

[[noreturn]] void Fail(const absl::Status& status) {
  std::fprintf(stderr, "%s\n", status.ToString().c_str());
  std::exit(1);
}

std::string_view BytesOf(const std::vector<float>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float)};
}

Cloud BareCloud(const BenchCloud& cloud) {
  Cloud bare(ScalarType::kFloat32, InvalidPointPolicy::kReject, NormalsInput::kAbsent);
  bare.Expect(cloud.size());
  absl::Status status = bare.Append(BytesOf(cloud.positions), {});
  if (status.ok()) status = bare.Finish();
  if (!status.ok()) Fail(status);
  return bare;
}

BenchCloud WithNoise(BenchCloud cloud, double sigma) {
  if (sigma == 0.0) return cloud;
  std::vector<curv::Vec3> positions(cloud.size());
  for (size_t i = 0; i < cloud.size(); ++i) {
    positions[i] = {cloud.positions[3 * i], cloud.positions[3 * i + 1], cloud.positions[3 * i + 2]};
  }
  curv::AddPositionNoise(sigma, 1, positions);
  for (size_t i = 0; i < cloud.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) cloud.positions[3 * i + axis] = static_cast<float>(positions[i][axis]);
  }
  return cloud;
}

NormalOptions Estimated() {
  NormalOptions options;
  options.source = NormalSource::kEstimate;
  return options;
}

NormalResult MustMakeNormals(const BenchCloud& cloud, const NormalOptions& options, WorkerPool& pool) {
  auto result = MakeNormals(BareCloud(cloud), options, pool);
  if (!result.ok()) Fail(result.status());
  return *std::move(result);
}

// What making normals of one cloud takes, in the median of some rounds.
struct Times {
  double wall;
  double cpu;  // of all threads
  NormalResult last;
};

Times TimeNormals(const BenchCloud& cloud, int rounds, WorkerPool& pool) {
  std::vector<double> walls, cpus;
  NormalResult last;
  for (int round = 0; round < rounds; ++round) {
    Cloud input = BareCloud(cloud);
    const double wall = WallSeconds(), cpu = CpuSeconds();
    auto made = MakeNormals(std::move(input), Estimated(), pool);
    walls.push_back(WallSeconds() - wall);
    cpus.push_back(CpuSeconds() - cpu);
    if (!made.ok()) Fail(made.status());
    last = *std::move(made);
  }
  return {Median(walls), Median(cpus), std::move(last)};
}

// Noise is in units of the spacing of the points: what it costs to see through it depends on that.
void MeasureTimes(const Flags& flags, Table& table, Targets& targets) {
  const size_t points = flags.quick ? 100'000 : 1'000'000;
  const BenchCloud torus = SurfaceCloud("torus", points, flags.clouds);
  const double spacing = std::sqrt(48.0 * std::numbers::pi * std::numbers::pi / static_cast<double>(points));
  for (const int threads : {1, 2}) {
    WorkerPool pool(threads);
    for (const double spacings : {0.0, 0.5, 1.0}) {
      const Times times = TimeNormals(WithNoise(torus, spacings * spacing), flags.RoundsOr(3), pool);
      const NormalReport& report = times.last.report;
      const JobCost& cost = times.last.cost;
      table.AddRow({torus.name, absl::StrCat(points), Digits(spacings), absl::StrCat(threads), Digits(times.wall),
                    Digits(times.cpu), Digits(*cost.seconds.index), Digits(SecondsOf(cost.phases, "normals")),
                    Digits(SecondsOf(cost.phases, "orientation")),
                    Digits(static_cast<double>(cost.peak_bytes) / static_cast<double>(points)),
                    std::string(NormalMethodName(*report.method)), absl::StrCat(report.neighbor_count),
                    Digits(*report.sigma / spacing), Digits(report.certificate.value_or(-1.0))});
      if (threads == 2) {
        const std::string what = absl::StrCat("normals of ", points, " points, noise ", spacings, " spacings");
        targets.AtMost(absl::StrCat(what, "; wall clock"), 3e-6 * static_cast<double>(points), times.wall, "s");
        targets.AtMost(absl::StrCat(what, "; both threads"), 6e-6 * static_cast<double>(points), times.cpu, "s");
      }
    }
  }
}

// Mean |H error| of an estimate at its best K; in *best, that K.
double LeastError(const BenchCloud& cloud, std::string_view estimator, const NormalOptions& normals, WorkerPool& pool,
                  uint32_t* best) {
  double least = 1e30;
  for (uint32_t k : {16u, 23u, 32u, 45u, 64u, 91u, 128u, 181u, 256u, 362u, 512u, 724u, 1024u}) {
    EstimatorOptions options;
    options.estimator = estimator;
    options.neighborhood = NeighborCount{k};
    auto result = EstimateCurvature(normals.source == NormalSource::kGiven ? ToCloud(cloud) : BareCloud(cloud), options,
                                    normals, pool);
    if (!result.ok()) Fail(result.status());
    double sum = 0.0, count = 0.0;
    for (size_t i = 0; i < cloud.size(); ++i) {
      const PointCurvature& point = result->field.points[i];
      if (point.status != PointStatus::kOk) continue;
      sum += std::abs(static_cast<double>(point.mean) - cloud.true_mean[i]);
      ++count;
    }
    if (sum / count < least) *best = k;
    least = std::min(least, sum / count);
  }
  return least;
}

void MeasureCurvature(const Flags& flags, Table& table, Targets& targets) {
  WorkerPool pool(2);
  for (const size_t points : flags.quick ? std::vector<size_t>{10'000} : std::vector<size_t>{10'000, 25'000, 50'000}) {
    for (const char* surface : {"goursat", "torus"}) {
      for (const double sigma : {0.0, 0.1}) {
        const BenchCloud cloud = WithNoise(SurfaceCloud(surface, points, flags.clouds), sigma);
        const NormalResult made = MustMakeNormals(cloud, Estimated(), pool);
        for (const std::string_view estimator : {"avg-hexagram", "jet", "aso"}) {
          uint32_t best_given = 0, best_made = 0;
          const double given = LeastError(cloud, estimator, NormalOptions(), pool, &best_given);
          const double estimated = LeastError(cloud, estimator, Estimated(), pool, &best_made);
          table.AddRow(
              {surface, absl::StrCat(points), Digits(sigma), std::string(estimator),
               absl::StrCat(std::string(NormalMethodName(*made.report.method)), " ", made.report.neighbor_count),
               Digits(given), absl::StrCat(best_given), Digits(estimated), absl::StrCat(best_made),
               Digits(estimated / given)});
          targets.AtMost(absl::StrCat("mean |H error| without normals over with; ", surface, " ", points, ", noise ",
                                      sigma, ", ", std::string(estimator)),
                         sigma == 0.0 ? 2.0 : 1.6, estimated / given, "x");
        }
      }
    }
  }
}

void Main(const Flags& flags) {
  Table times("normals_time",
              {"surface", "points", "noise; spacings", "threads", "wall s", "CPU s", "index s", "normals s",
               "orientation s", "peak bytes/point", "method", "K", "noise found; spacings", "certificate"});
  Table curvature("normals_curvature", {"surface", "points", "noise", "estimator", "normals by", "error with normals",
                                        "best K", "error without", "its best K", "ratio"});
  Targets targets("normals");
  MeasureTimes(flags, times, targets);
  times.Finish(flags.out);
  MeasureCurvature(flags, curvature, targets);
  curvature.Finish(flags.out);
  targets.Finish(flags.out);
}

}  // namespace
}  // namespace curvd::bench

int main(int argc, char** argv) {
  curvd::bench::Main(curvd::bench::ParseFlags(argc, argv, "Normals from positions alone"));
}
