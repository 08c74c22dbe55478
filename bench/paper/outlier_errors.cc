// Errors of automatic estimates of clouds with outliers, beside those of the same clouds without, and of estimates that
// keep the outliers: outliers near the surface, and anywhere in its box.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_format.h"
#include "bench/paper/errors.h"
#include "bench/paper/samples.h"
#include "core/job/estimation_job.h"

namespace curvd::bench {
namespace {

// How estimates are made.
struct Way {
  size_t points;
  uint64_t seed;
  bool makes_normals;
  WorkerPool& pool;
};

double Distance(const curv::Vec3& a, const curv::Vec3& b) {
  const curv::Vec3 offset = a - b;
  return std::sqrt(offset.x * offset.x + offset.y * offset.y + offset.z * offset.z);
}

// The root of the area for a point: the nearest one of points that lie by chance is half of it away, in the median.
double SpacingOf(const Samples& samples) {
  constexpr size_t kLookedAt = 200;
  std::vector<double> nearest;
  for (size_t i = 0; i < samples.size(); i += std::max<size_t>(1, samples.size() / kLookedAt)) {
    double least = 1e300;
    for (size_t j = 0; j < samples.size(); ++j) {
      if (j != i) least = std::min(least, Distance(samples.positions[i], samples.positions[j]));
    }
    nearest.push_back(least);
  }
  std::nth_element(nearest.begin(), nearest.begin() + static_cast<std::ptrdiff_t>(nearest.size() / 2), nearest.end());
  return 2.0 * nearest[nearest.size() / 2];
}

void Add(const curv::Vec3& position, const curv::Vec3& normal, Samples& to) {
  const double length = Distance(normal, {});
  to.positions.push_back(position);
  to.normals.push_back((1.0 / length) * normal);
  to.truth.push_back({});
}

// Two to ten spacings above or below a point, with a normal that is off from its own by 0.2 in each component.
void AddNearby(size_t count, double spacing, uint64_t seed, Samples& samples) {
  const size_t points = samples.size();
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> spacings(2.0, 10.0);
  std::normal_distribution<double> error(0.0, 0.2);
  for (size_t n = 0; n < count; ++n) {
    const size_t i = random() % points;
    const curv::Vec3 normal = samples.normals[i];
    const double height = (n % 2 == 0 ? 1.0 : -1.0) * spacings(random) * spacing;
    Add(samples.positions[i] + height * normal, normal + curv::Vec3{error(random), error(random), error(random)},
        samples);
  }
}

// Even over the box of the points, a tenth wider, with normals of any direction.
void AddAnywhere(size_t count, uint64_t seed, Samples& samples) {
  curv::Vec3 low = samples.positions[0], high = low;
  for (const curv::Vec3& position : samples.positions) {
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], position[axis]);
      high[axis] = std::max(high[axis], position[axis]);
    }
  }
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> part(-0.05, 1.05);
  std::normal_distribution<double> component;
  for (size_t n = 0; n < count; ++n) {
    curv::Vec3 position;
    for (int axis = 0; axis < 3; ++axis) position[axis] = low[axis] + part(random) * (high[axis] - low[axis]);
    Add(position, {component(random), component(random), component(random)}, samples);
  }
}

struct Outcome {
  size_t found = 0, mistaken = 0;
  FieldErrors errors;  // of the points of the surface
};

// The first way.points samples are those of the surface.
Outcome Measure(const Samples& samples, const Way& way, bool keeps_outliers = false) {
  const EstimatorOptions options{.estimator = "auto", .neighborhood = AutomaticScale{}};
  const EstimationResult result = EstimateSamples(samples, options, way.makes_normals, way.pool, keeps_outliers);
  Outcome outcome;
  for (size_t i = 0; i < samples.size(); ++i) {
    if (result.field.points[i].status != PointStatus::kOutlier) continue;
    ++(i < way.points ? outcome.mistaken : outcome.found);
  }
  outcome.errors =
      MeasureErrors(result.field.points.span().first(way.points), std::span(samples.truth).first(way.points));
  return outcome;
}

void Try(const std::string& surface, double noise, bool nearby, double share, const Way& way) {
  const Samples exact = SampleAtRandom(surface, way.points, way.seed);
  Way of_all = way;
  of_all.points = exact.size();
  const double spacing = SpacingOf(exact);
  const Samples without = Perturbed(exact, noise * spacing, noise > 0.0 ? 0.1 : 0.0, way.seed + 1);
  Samples with = without;
  const auto count = static_cast<size_t>(share * static_cast<double>(exact.size()));
  nearby ? AddNearby(count, spacing, way.seed + 2, with) : AddAnywhere(count, way.seed + 2, with);
  const Outcome alone = Measure(without, of_all), kept = Measure(with, of_all, true), left_out = Measure(with, of_all);
  absl::PrintF("%-9s %4.1f %-8s %4.1f %% | %5d %5d %4d | %8.3g |", surface, noise, nearby ? "nearby" : "anywhere",
               100.0 * share, count, left_out.found, left_out.mistaken, alone.errors.mean.mean);
  for (const Outcome& outcome : {kept, left_out}) {
    absl::PrintF(" %6.2f %% %8.3g %8.3g |",
                 100.0 * static_cast<double>(outcome.errors.failed) / static_cast<double>(exact.size()),
                 outcome.errors.mean.mean / alone.errors.mean.mean,
                 outcome.errors.mean.median / alone.errors.mean.median);
  }
  absl::PrintF("\n");
  std::fflush(stdout);
}

int Main(const std::vector<std::string>& surfaces, size_t points, uint64_t seed, bool makes_normals) {
  WorkerPool pool(static_cast<int>(std::max(1u, std::thread::hardware_concurrency())));
  const Way way{points, seed, makes_normals, pool};
  absl::PrintF(
      "surface, noise (spacings), outliers | there, found, mistaken | H error without any |"
      " kept, then left out: no result, mean and median H error over those without\n");
  for (const std::string& surface : surfaces) {
    for (const double noise : {0.0, 0.1, 0.3}) {
      for (const bool nearby : {true, false}) {
        for (const double share : {0.001, 0.01, 0.05}) Try(surface, noise, nearby, share, way);
      }
    }
  }
  return 0;
}

}  // namespace
}  // namespace curvd::bench

int main(int argc, char** argv) {
  std::vector<std::string> surfaces = {"torus", "ellipsoid", "goursat", "peanut", "lumpy"};
  size_t points = 20'000;
  uint64_t seed = 1;
  bool makes_normals = false;
  CLI::App app("Errors of automatic estimates of clouds with outliers beside those of the clouds without");
  app.add_option("--surfaces", surfaces, "Which ones, by names with commas between")->delimiter(',');
  app.add_option("--points", points, "Of each surface");
  app.add_option("--seed", seed, "Of samples, noise and outliers");
  app.add_flag("--make-normals", makes_normals, "Normals are made of the positions, in place of the samples' own");
  CLI11_PARSE(app, argc, argv);
  return curvd::bench::Main(surfaces, points, seed, makes_normals);
}
