// Errors of automatic estimates of clouds of two parts, one with more noise than the other, beside those of each part
// as it is estimated alone: two clouds side by side, and surfaces of which one half is exact.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <numeric>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/strings/str_format.h"
#include "bench/paper/errors.h"
#include "bench/paper/samples.h"
#include "core/job/estimation_job.h"

namespace curvd::bench {
namespace {

// Half of a surface counts from this share of its width on: neighborhoods nearer to its middle have points of both.
constexpr double kBorder = 0.15;

struct Part {
  std::string surface;
  size_t points;
  double position_noise, normal_noise;  // in the paper's unit

  Samples Sample(uint64_t seed) const {
    const Samples exact = SampleAtRandom(surface, points, seed);
    return Perturbed(exact, position_noise * NoiseUnit(surface), normal_noise, seed + 1);
  }
  std::string Name() const { return absl::StrFormat("%s %d, %g/%g", surface, points, position_noise, normal_noise); }
};

constexpr size_t kParts = 2;
using Errors = std::array<FieldErrors, kParts>;

// Which points of a cloud are measured for each part.
using Places = std::array<std::vector<size_t>, kParts>;

void Add(const Samples& from, size_t i, double shift, Samples& to) {
  to.positions.push_back({from.positions[i][0] + shift, from.positions[i][1], from.positions[i][2]});
  to.normals.push_back(from.normals[i]);
  to.truth.push_back(from.truth[i]);
}

// How estimates are made.
struct Way {
  uint64_t seed;
  bool makes_normals;
  WorkerPool& pool;
};

Errors Measure(const Samples& samples, const Places& places, const Way& way) {
  const EstimatorOptions options{.estimator = "auto", .neighborhood = AutomaticScale{}};
  const EstimationResult result = EstimateSamples(samples, options, way.makes_normals, way.pool);
  Errors errors;
  for (size_t part = 0; part < kParts; ++part) {
    std::vector<PointCurvature> points;
    std::vector<curv::SurfaceGeometry> truth;
    for (const size_t i : places[part]) {
      points.push_back(result.field.points[i]);
      truth.push_back(samples.truth[i]);
    }
    errors[part] = MeasureErrors(points, truth);
  }
  return errors;
}

// Of errors; those below are rounding.
double Ratio(double both, double alone) {
  constexpr double kRounding = 1e-6;
  return std::max(both, kRounding) / std::max(alone, kRounding);
}

void Print(const std::string& first, const std::string& second, const Errors& both, const Errors& alone) {
  absl::PrintF("%-26s %-26s", first, second);
  for (size_t part = 0; part < kParts; ++part) {
    absl::PrintF(" | %9.3g %5.2f %5.2f", alone[part].mean.mean, Ratio(both[part].mean.mean, alone[part].mean.mean),
                 Ratio(both[part].gaussian.mean, alone[part].gaussian.mean));
  }
  absl::PrintF("\n");
  std::fflush(stdout);
}

// Far enough from each other that no neighborhood has points of both.
void SideBySide(const Part& first, const Part& second, const Way& way) {
  const std::array<Samples, kParts> samples = {first.Sample(way.seed), second.Sample(way.seed + 2)};
  double shift = 0.0;
  for (const Samples& one : samples) {
    for (const curv::Vec3& position : one.positions) shift = std::max({shift, 4.0 * position[0], -4.0 * position[0]});
  }
  Samples both;
  Places places, all;
  Errors alone;
  for (size_t part = 0; part < kParts; ++part) {
    for (size_t i = 0; i < samples[part].size(); ++i) {
      places[part].push_back(both.size());
      Add(samples[part], i, static_cast<double>(part) * shift, both);
    }
    all[part].resize(samples[part].size());
    std::iota(all[part].begin(), all[part].end(), size_t{0});
    alone[part] = Measure(samples[part], {all[part], all[part]}, way)[0];
  }
  Print(first.Name(), second.Name(), Measure(both, places, way), alone);
}

// Exact where x is negative.
void Halves(const Part& noisy, const Way& way) {
  const Part exact = {noisy.surface, noisy.points, 0.0, 0.0};
  const Samples clean = exact.Sample(way.seed), all_noisy = noisy.Sample(way.seed);
  const auto [least, most] = std::minmax_element(clean.positions.begin(), clean.positions.end(),
                                                 [](const auto& a, const auto& b) { return a[0] < b[0]; });
  const double border = kBorder * ((*most)[0] - (*least)[0]);
  Samples both;
  Places places;
  for (size_t i = 0; i < clean.size(); ++i) {
    const double x = clean.positions[i][0];
    Add(x < 0.0 ? clean : all_noisy, i, 0.0, both);
    if (x < -border) places[0].push_back(i);
    if (x > border) places[1].push_back(i);
  }
  const Errors alone = {Measure(clean, places, way)[0], Measure(all_noisy, places, way)[1]};
  Print("half of " + exact.Name(), "half of " + noisy.Name(), Measure(both, places, way), alone);
}

int Main(uint64_t seed, bool makes_normals) {
  WorkerPool pool(static_cast<int>(std::max(1u, std::thread::hardware_concurrency())));
  const Way way{seed, makes_normals, pool};
  absl::PrintF("%-26s %-26s | alone: H, in both: times that, and of G\n", "first part", "second part");
  const std::pair<Part, Part> pairs[] = {
      {{"goursat", 25'000, 0.0, 0.0}, {"goursat", 25'000, 0.1, 0.1}},
      {{"torus", 75'000, 0.0, 0.0}, {"goursat", 10'000, 0.1, 0.2}},
      {{"goursat", 10'000, 0.0, 0.1}, {"goursat", 75'000, 0.1, 0.0}},
      {{"torus", 10'000, 0.1, 0.0}, {"goursat", 50'000, 0.1, 0.2}},
      {{"peanut", 20'000, 0.0, 0.1}, {"lumpy", 20'000, 0.1, 0.1}},
      {{"ellipsoid", 15'000, 0.0, 0.0}, {"pillow", 30'000, 0.05, 0.05}},
  };
  for (const auto& [first, second] : pairs) SideBySide(first, second, way);
  for (const char* const surface : {"sphere", "torus", "goursat", "ellipsoid", "peanut", "lumpy"}) {
    for (const double normal_noise : {0.0, 0.1}) {
      if (normal_noise == 0.0 || !makes_normals) Halves({surface, 20'000, 0.1, normal_noise}, way);
    }
  }
  return 0;
}

}  // namespace
}  // namespace curvd::bench

int main(int argc, char** argv) {
  uint64_t seed = 1;
  bool makes_normals = false;
  CLI::App app("Errors of automatic estimates of clouds of two parts beside those of each part alone");
  app.add_option("--seed", seed, "Of samples and noise");
  app.add_flag("--make-normals", makes_normals, "Normals are made of the positions, in place of the samples' own");
  CLI11_PARSE(app, argc, argv);
  return curvd::bench::Main(seed, makes_normals);
}
