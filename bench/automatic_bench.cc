// The automatic choice, beside one estimate with the most neighbors that it uses; whole core in one thread.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "bench/core_run.h"
#include "bench/flags.h"
#include "bench/table.h"
#include "core/job/estimation_job.h"

namespace curvd::bench {
namespace {

// Of positions in the length unit, of normals along each axis before they are normalized.
struct Noise {
  float position, normal;
};

BenchCloud WithNoise(BenchCloud cloud, Noise noise) {
  std::mt19937 generator(1);
  std::normal_distribution<float> gaussian;
  for (float& coordinate : cloud.positions) coordinate += noise.position * gaussian(generator);
  for (size_t i = 0; i < cloud.normals.size(); i += 3) {
    float* const normal = &cloud.normals[i];
    for (int axis = 0; axis < 3; ++axis) normal[axis] += noise.normal * gaussian(generator);
    const float length = std::hypot(normal[0], normal[1], normal[2]);
    for (int axis = 0; axis < 3; ++axis) normal[axis] /= length;
  }
  return cloud;
}

EstimatorOptions AutomaticOptions() {
  EstimatorOptions options;
  options.estimator = kAutomaticEstimator;
  options.neighborhood = AutomaticScale{};
  return options;
}

// The estimate with the most neighbors of those that have a hundredth of the weights, or of all; of several with as
// many, the one that weighs most.
ScaleOutcome LargestUsed(const BenchCloud& cloud, WorkerPool& pool) {
  constexpr double kUsed = 0.01;
  const auto result = EstimateCurvature(ToCloud(cloud), AutomaticOptions(), pool);
  if (!result.ok() || !result->scale_report.has_value()) {
    std::fprintf(stderr, "%s: no choice\n", cloud.name.c_str());
    std::exit(1);
  }
  const ScaleOutcome* largest = nullptr;
  for (const ScaleOutcome& outcome : result->scale_report->outcomes) {
    if (outcome.share < kUsed) continue;
    if (largest == nullptr || outcome.neighbor_count > largest->neighbor_count ||
        (outcome.neighbor_count == largest->neighbor_count && outcome.share > largest->share)) {
      largest = &outcome;
    }
  }
  if (largest == nullptr) {
    std::fprintf(stderr, "%s: nothing is used\n", cloud.name.c_str());
    std::exit(1);
  }
  return *largest;
}

std::string NameOf(const ScaleOutcome& outcome) {
  const std::string name(outcome.estimator);
  return outcome.degree == 0 ? name : absl::StrCat(name, " of degree ", outcome.degree, ",");
}

EstimatorOptions OptionsOf(const ScaleOutcome& outcome) {
  EstimatorOptions options = OptionsFor(outcome.estimator, outcome.neighbor_count, 2);
  // Jets of degree 6 are the choice's own: those of degree 4, which cost less, stand for them.
  if (outcome.estimator == "jet") options.jet_degree = std::min(outcome.degree, kMaxJetDegree);
  if (outcome.estimator == "normal-regression") options.regression_degree = outcome.degree;
  options.project = true;
  return options;
}

void Measure(const BenchCloud& cloud, Noise noise, int rounds, WorkerPool& pool, Table& table, Targets& targets) {
  const ScaleOutcome largest = LargestUsed(cloud, pool);
  const std::string name = absl::StrCat(cloud.name, " ", cloud.size(), ", noise ", noise.position, " / ", noise.normal);
  SideBySide comparison(name);
  comparison.Add("auto", [&] { return RunCore(cloud, AutomaticOptions(), pool); });
  comparison.Add("largest", [&] { return RunCore(cloud, OptionsOf(largest), pool); });
  auto medians = comparison.Run(rounds);
  const double automatic = medians["auto"]["total"], one = medians["largest"]["total"];
  table.AddRow({cloud.name, absl::StrCat(cloud.size()), absl::StrCat(noise.position, " / ", noise.normal),
                Digits(automatic), Digits(medians["auto"]["outliers"]),
                absl::StrCat(NameOf(largest), " ", largest.neighbor_count), Digits(one), Digits(automatic / one)});
  targets.AtMost(absl::StrCat(name, ": auto over the largest that it uses"), 4.0, automatic / one, "x");
}

void Main(const Flags& flags) {
  Table table("automatic", {"cloud", "points", "noise", "auto, s", "outliers, s", "largest", "it alone, s", "times"});
  Targets targets("automatic");
  WorkerPool pool(1);
  std::vector<size_t> sizes = {10'000, 50'000};
  if (!flags.quick) sizes.push_back(200'000);
  if (flags.full) sizes.push_back(1'000'000);
  for (const size_t points : sizes) {
    for (const char* surface : {"torus", "goursat"}) {
      const BenchCloud exact = SurfaceCloud(surface, points, flags.clouds);
      for (const Noise noise : {Noise{0.0f, 0.0f}, Noise{0.02f, 0.1f}}) {
        Measure(WithNoise(exact, noise), noise, flags.RoundsOr(5), pool, table, targets);
      }
    }
  }
  table.Finish(flags.out);
  targets.Finish(flags.out);
}

}  // namespace
}  // namespace curvd::bench

int main(int argc, char** argv) {
  curvd::bench::Main(curvd::bench::ParseFlags(argc, argv, "The automatic choice, in one thread"));
}
