#include "bench/paper/height_errors.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "bench/paper/nearest_of_samples.h"
#include "client/surfaces/random.h"

namespace curvd::bench {
namespace {

using curv::Vec3;

constexpr uint64_t kClumpStream = 111, kGrowthStream = 112;

double SpacingOf(const Samples& samples, const NearestOfSamples& nearest) {
  constexpr size_t kCount = 9;  // a disk that reaches to the eighth neighbor has the area of eight points
  std::vector<double> spacings, squared_distances;
  std::vector<uint32_t> found;
  for (size_t i = 0; i < samples.size(); ++i) {
    nearest.Find(i, kCount, found, squared_distances);
    if (found.size() < kCount) continue;
    spacings.push_back(std::sqrt(squared_distances.back() * std::numbers::pi / (kCount - 1)));
  }
  if (spacings.empty()) return 0.0;
  const auto middle = spacings.begin() + static_cast<std::ptrdiff_t>(spacings.size() / 2);
  std::nth_element(spacings.begin(), middle, spacings.end());
  return *middle;
}

// Of standard deviation 1.
std::vector<double> Clumps(const Samples& samples, const NearestOfSamples& nearest, double length, double spacing,
                           uint64_t seed) {
  const curv::CounterRandom random(seed, kClumpStream);
  // Those within three standard deviations.
  const auto count = static_cast<size_t>(std::ceil(9.0 * std::numbers::pi * length * length)) + 1;
  const double width = length * spacing;
  std::vector<double> heights(samples.size()), squared_distances;
  std::vector<uint32_t> found;
  for (size_t i = 0; i < samples.size(); ++i) {
    nearest.Find(i, count, found, squared_distances);
    double sum = 0.0, squares = 0.0;
    for (size_t j = 0; j < found.size(); ++j) {
      const double weight = std::exp(-0.5 * squared_distances[j] / (width * width));
      sum += weight * random.Gaussian(found[j]);
      squares += weight * weight;
    }
    heights[i] = sum / std::sqrt(squares);
  }
  return heights;
}

std::vector<double> Waves(const Samples& samples, double length) {
  const double turn = 2.0 * std::numbers::pi / length;
  std::vector<double> heights;
  heights.reserve(samples.size());
  for (const Vec3& p : samples.positions) {
    heights.push_back((std::sin(turn * p.x) + std::sin(turn * p.y) + std::sin(turn * p.z)) / 3.0);
  }
  return heights;
}

std::vector<double> Growth(const Samples& samples, uint64_t seed) {
  const curv::CounterRandom random(seed, kGrowthStream);
  const auto [first, last] = std::minmax_element(samples.positions.begin(), samples.positions.end(),
                                                 [](const Vec3& a, const Vec3& b) { return a.x < b.x; });
  std::vector<double> heights;
  heights.reserve(samples.size());
  for (size_t i = 0; i < samples.size(); ++i) {
    heights.push_back((samples.positions[i].x - first->x) / (last->x - first->x) * random.Gaussian(i));
  }
  return heights;
}

Samples RoundedAlongZ(Samples samples, double step) {
  for (Vec3& position : samples.positions) position.z = step * std::round(position.z / step);
  return samples;
}

std::vector<double> HeightsOf(const Samples& samples, const NearestOfSamples& nearest, const HeightFlags& flags,
                              double spacing, uint64_t seed) {
  if (flags.kind == HeightErrorKind::kWaves) return Waves(samples, flags.length * spacing);
  if (flags.kind == HeightErrorKind::kClumps) return Clumps(samples, nearest, flags.length, spacing, seed);
  return Growth(samples, seed);
}

}  // namespace

void AddHeightFlags(CLI::App& app, HeightFlags& flags) {
  const std::map<std::string, HeightErrorKind> kinds = {{"none", HeightErrorKind::kNone},
                                                        {"waves", HeightErrorKind::kWaves},
                                                        {"clumps", HeightErrorKind::kClumps},
                                                        {"steps", HeightErrorKind::kSteps},
                                                        {"growth", HeightErrorKind::kGrowth}};
  app.add_option(
         "--height-errors", flags.kind,
         "Errors of heights besides independent noise, while normals stay: none, waves, clumps (averaged noise), "
         "steps (z is rounded) or growth (noise that grows along x)")
      ->transform(CLI::CheckedTransformer(kinds));
  app.add_option("--height-size", flags.size,
                 "Of these errors, in spacings: the amplitude of waves, the distance of steps, or a standard deviation")
      ->check(CLI::PositiveNumber);
  app.add_option("--height-length", flags.length,
                 "In spacings: of waves, or the standard deviation of the weights that clumps are averaged with")
      ->check(CLI::Range(0.5, 1000.0));
}

Samples WithHeightErrors(const Samples& samples, const HeightFlags& flags, uint64_t seed) {
  if (flags.kind == HeightErrorKind::kNone || samples.size() == 0) return samples;
  const NearestOfSamples nearest(samples);
  const double spacing = SpacingOf(samples, nearest);
  if (flags.kind == HeightErrorKind::kSteps) return RoundedAlongZ(samples, flags.size * spacing);
  const std::vector<double> heights = HeightsOf(samples, nearest, flags, spacing, seed);
  Samples moved = samples;
  for (size_t i = 0; i < samples.size(); ++i) {
    moved.positions[i] += (flags.size * spacing * heights[i]) * samples.normals[i];
  }
  return moved;
}

}  // namespace curvd::bench
