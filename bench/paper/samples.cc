#include "bench/paper/samples.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numeric>
#include <string_view>
#include <variant>

#include "absl/status/status.h"
#include "bench/paper/held_out_surfaces.h"
#include "bench/paper/nearest_of_samples.h"
#include "client/io/oriented_cloud.h"
#include "client/io/table_file.h"
#include "client/surfaces/noise.h"
#include "client/surfaces/random.h"
#include "core/job/normals_job.h"

namespace curvd::bench {
namespace {

using curv::Vec3;

constexpr uint64_t kThinningStream = 101, kRandomStream = 102, kFallingStream = 103;

void DieUnless(const absl::Status& status) {
  if (status.ok()) return;
  std::fprintf(stderr, "%s\n", status.ToString().c_str());
  std::exit(1);
}

std::unique_ptr<curv::Surface> SurfaceNamed(const std::string& name) {
  if (auto surface = MakeHeldOutSurface(name); surface != nullptr) return surface;
  auto surface = curv::MakeSurface(name);
  DieUnless(surface.status());
  return *std::move(surface);
}

// Adds the position with the exact normal and curvature there.
void AddExact(const curv::Surface& surface, const Vec3& position, Samples& samples) {
  samples.positions.push_back(position);
  samples.truth.push_back(surface.At(position));
  samples.normals.push_back(samples.truth.back().normal);
}

// Where a ray enters the surface.
std::optional<Vec3> FirstHit(const curv::Surface& surface, const Vec3& origin, const Vec3& direction, double length) {
  constexpr int kSteps = 400;  // a twentieth of the smallest feature
  constexpr int kBisections = 50;
  const auto value_at = [&](double t) {
    Vec3 gradient;
    return surface.Evaluate(origin + t * direction, gradient);
  };
  for (int step = 1; step <= kSteps; ++step) {
    double outside = length * (step - 1) / kSteps, inside = length * step / kSteps;
    if (value_at(inside) > 0.0) continue;
    for (int i = 0; i < kBisections; ++i) {
      const double middle = 0.5 * (outside + inside);
      (value_at(middle) > 0.0 ? outside : inside) = middle;
    }
    return origin + inside * direction;
  }
  return std::nullopt;
}

std::vector<float> Packed(const std::vector<Vec3>& vectors) {
  std::vector<float> packed;
  packed.reserve(3 * vectors.size());
  for (const Vec3& v : vectors) {
    for (int axis = 0; axis < 3; ++axis) packed.push_back(static_cast<float>(v[axis]));
  }
  return packed;
}

std::vector<std::array<double, 3>> ViewpointsOf(const Samples& samples) {
  std::vector<std::array<double, 3>> viewpoints;
  for (size_t i = 0; i < samples.size(); ++i) {
    const Vec3 &p = samples.positions[i], &n = samples.normals[i];
    viewpoints.push_back({p[0] + n[0], p[1] + n[1], p[2] + n[2]});
  }
  return viewpoints;
}

}  // namespace

Samples SampleEvenly(const std::string& surface_name, size_t points, uint64_t seed) {
  const auto surface = SurfaceNamed(surface_name);
  const auto positions = curv::SampleEvenly(*surface, points, seed);
  DieUnless(positions.status());
  Samples samples{.surface = surface_name, .sampling = "even", .positions = {}, .normals = {}, .truth = {}};
  for (const Vec3& position : *positions) AddExact(*surface, position, samples);
  return samples;
}

Samples SampleThinned(const std::string& surface_name, size_t points, uint64_t seed) {
  const auto surface = SurfaceNamed(surface_name);
  const curv::CounterRandom random(seed, kThinningStream);
  const Samples even = SampleEvenly(surface_name, points, seed);
  Samples samples{.surface = surface_name, .sampling = "thinned", .positions = {}, .normals = {}, .truth = {}};
  for (size_t i = 0; i < even.size(); ++i) {
    const Vec3& p = even.positions[i];
    const double along = (p.x + p.y) * (p.x + p.y), across = (p.x - p.y) * (p.x - p.y);
    if (random.Uniform(i) * (along + across) < along + 0.1 * across) AddExact(*surface, p, samples);
  }
  return samples;
}

Samples SampleFalling(const std::string& surface_name, size_t points, uint64_t seed) {
  constexpr double kLeast = 0.01;                               // probability to stay
  const double mean_share = (kLeast - 1.0) / std::log(kLeast);  // where x is spread evenly
  const auto surface = SurfaceNamed(surface_name);
  const auto positions =
      curv::SampleEvenly(*surface, static_cast<size_t>(static_cast<double>(points) / mean_share), seed);
  DieUnless(positions.status());
  const auto [first, last] =
      std::minmax_element(positions->begin(), positions->end(), [](const Vec3& a, const Vec3& b) { return a.x < b.x; });
  const curv::CounterRandom random(seed, kFallingStream);
  Samples samples{.surface = surface_name, .sampling = "falling", .positions = {}, .normals = {}, .truth = {}};
  for (size_t i = 0; i < positions->size(); ++i) {
    const Vec3& p = (*positions)[i];
    if (random.Uniform(i) < std::pow(kLeast, (p.x - first->x) / (last->x - first->x))) AddExact(*surface, p, samples);
  }
  return samples;
}

Samples SampleAtRandom(const std::string& surface_name, size_t points, uint64_t seed) {
  constexpr size_t kOf = 8;  // of so many even samples, one each
  const auto surface = SurfaceNamed(surface_name);
  const auto positions = curv::SampleEvenly(*surface, kOf * points, seed);
  DieUnless(positions.status());
  const curv::CounterRandom random(seed, kRandomStream);
  Samples samples{.surface = surface_name, .sampling = "random", .positions = {}, .normals = {}, .truth = {}};
  for (size_t i = 0; i < positions->size(); ++i) {
    if (random.Uniform(i) * kOf < 1.0) AddExact(*surface, (*positions)[i], samples);
  }
  return samples;
}

Samples SampleScanned(const std::string& surface_name) {
  constexpr double kLinesPoints = 90.0;  // across the bounds
  constexpr double kLineDistance = 2.5;  // over the distance along a line
  constexpr double kLeastCosine = 0.25;  // between the ray and the normal
  const auto surface = SurfaceNamed(surface_name);
  const curv::Box box = surface->bounds();
  const double width = box.high.x - box.low.x;
  const Vec3 scanner{0.0, 0.0, box.high.z + width};
  const double half_field = std::atan(0.5), column_step = 1.0 / kLinesPoints, row_step = kLineDistance * column_step;
  Samples samples{.surface = surface_name, .sampling = "scanned", .positions = {}, .normals = {}, .truth = {}};
  for (double row = -half_field; row <= half_field; row += row_step) {
    for (double column = -half_field; column <= half_field; column += column_step) {
      const Vec3 ray = curv::Normalized(Vec3{std::tan(column), std::tan(row), -1.0});
      const std::optional<Vec3> hit = FirstHit(*surface, scanner, ray, 3.0 * width);
      if (!hit.has_value() || -curv::Dot(ray, surface->At(*hit).normal) < kLeastCosine) continue;
      AddExact(*surface, *hit, samples);
    }
  }
  return samples;
}

Samples SampleAs(const std::string& sampling, const std::string& surface, size_t points, uint64_t seed) {
  if (sampling == "thinned") return SampleThinned(surface, 2 * points, seed);
  if (sampling == "falling") return SampleFalling(surface, points, seed);
  if (sampling == "random") return SampleAtRandom(surface, points, seed);
  if (sampling == "scanned") return SampleScanned(surface);
  return SampleEvenly(surface, points, seed);
}

std::optional<Samples> LoadSamples(const std::string& path, const std::string& surface_name,
                                   const std::string& sampling) {
  if (!std::filesystem::exists(path)) return std::nullopt;
  const auto surface = SurfaceNamed(surface_name);
  const auto table = curv::LoadTable(path);
  DieUnless(table.status());
  const auto cloud = curv::ExtractCloud(*table);
  DieUnless(cloud.status());
  Samples samples{.surface = surface_name, .sampling = sampling, .positions = {}, .normals = {}, .truth = {}};
  std::visit(
      [&](const auto& packed) {
        for (size_t i = 0; i + 2 < packed.positions.size(); i += 3) {
          samples.positions.push_back({packed.positions[i], packed.positions[i + 1], packed.positions[i + 2]});
          samples.normals.push_back({packed.normals[i], packed.normals[i + 1], packed.normals[i + 2]});
          samples.truth.push_back(surface->At(surface->Project(samples.positions.back())));
        }
      },
      *cloud);
  return samples;
}

double NoiseUnit(const std::string& surface) {
  // The paper's own two.
  if (surface == "goursat" || surface == "torus") return 1.0;
  const curv::Box box = SurfaceNamed(surface)->bounds();
  double extent = 0.0;
  for (int axis = 0; axis < 3; ++axis) extent = std::max(extent, box.high[axis] - box.low[axis]);
  return extent / 20.0;
}

Samples Perturbed(const Samples& samples, double position_noise, double normal_noise, uint64_t seed) {
  Samples perturbed = samples;
  curv::AddPositionNoise(position_noise, seed, perturbed.positions);
  if (normal_noise > 0.0) curv::AddNormalNoise(normal_noise, seed, perturbed.normals);
  return perturbed;
}

namespace {

// As a part of a larger cloud, points have ids that are not their places.
Cloud ToCloud(const Samples& samples, bool is_part) {
  const auto bytes = [](const std::vector<float>& values) {
    return std::string_view(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float));
  };
  const std::vector<float> positions = Packed(samples.positions), normals = Packed(samples.normals);
  Cloud cloud;
  if (is_part) {
    std::vector<uint64_t> ids(samples.size());
    std::iota(ids.begin(), ids.end(), uint64_t{1});
    DieUnless(cloud.Describe(ids.size(), ids, {}));
  }
  DieUnless(cloud.Append(bytes(positions), bytes(normals)));
  DieUnless(cloud.Finish());
  return cloud;
}

}  // namespace

Cloud ToCloud(const Samples& samples) { return ToCloud(samples, false); }

Samples WithFittedNormals(const Samples& samples, NormalMethod method, uint32_t neighbor_count, size_t scans,
                          WorkerPool& pool) {
  Samples fitted = samples;
  for (size_t first = 0; first < scans; ++first) {
    Samples scan;
    for (size_t i = first; i < samples.size(); i += scans) {
      scan.positions.push_back(samples.positions[i]);
      scan.normals.push_back(samples.normals[i]);
    }
    const auto viewpoints = ViewpointsOf(scan);
    const NormalOptions options{.source = NormalSource::kEstimate,
                                .method = method,
                                .neighborhood = NeighborCount{neighbor_count},
                                .sides = SidesTowardViewpoints{viewpoints}};
    const auto made = MakeNormals(ToCloud(scan), options, pool);
    DieUnless(made.status());
    for (size_t i = 0; i < scan.size(); ++i) {
      const PointNormal& point = made->normals[i];
      if (point.status != PointStatus::kOk) continue;
      fitted.normals[first + i * scans] = {point.normal[0], point.normal[1], point.normal[2]};
    }
  }
  return fitted;
}

Samples WithSmoothedNormals(const Samples& samples, size_t count) {
  if (samples.size() == 0) return samples;
  const NearestOfSamples index(samples);
  Samples smoothed = samples;
  std::vector<uint32_t> nearest;
  std::vector<double> squared_distances;
  for (size_t i = 0; i < samples.size(); ++i) {
    index.Find(i, count, nearest, squared_distances);
    Vec3 sum;
    for (const uint32_t j : nearest) sum += samples.normals[j];
    const double length = std::hypot(sum.x, sum.y, sum.z);
    smoothed.normals[i] = {sum.x / length, sum.y / length, sum.z / length};
  }
  return smoothed;
}

EstimationResult EstimateSamples(const Samples& samples, const EstimatorOptions& options, bool makes_normals,
                                 WorkerPool& pool, bool is_part) {
  NormalOptions normals;
  std::vector<std::array<double, 3>> viewpoints;
  if (makes_normals) {
    viewpoints = ViewpointsOf(samples);
    normals.source = NormalSource::kEstimate;
    normals.sides = SidesTowardViewpoints{viewpoints};
  }
  auto result = EstimateCurvature(ToCloud(samples, is_part), options, normals, pool);
  DieUnless(result.status());
  return *std::move(result);
}

}  // namespace curvd::bench
