// Errors of automatic estimates near sharp edges, by the distance to the edge.
//
// Each row is one solid under one noise: the mean |H error| times the spacing of the samples, of points in bands of
// distance to the nearest edge (in spacings), beside what avg-hexagram makes of 16 and of 50 neighbors. The truth at a
// sample is the curvature of the face that it lies on.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "absl/strings/str_format.h"
#include "bench/paper/samples.h"
#include "client/surfaces/noise.h"
#include "client/surfaces/vec3.h"
#include "core/job/estimation_job.h"

namespace curvd::bench {
namespace {

using curv::Vec3;

// Samples of faces, spaced by 1 on average, with the mean curvature and the distance to the nearest edge at each.
struct Solid {
  Samples samples;
  std::vector<double> mean;
  std::vector<double> distance;

  void Add(const Vec3& position, const Vec3& normal, double mean_curvature, double to_edge) {
    samples.positions.push_back(position);
    samples.normals.push_back(normal);
    mean.push_back(mean_curvature);
    distance.push_back(to_edge);
  }
};

// Calls visit(a, b) for one place in each cell of a grid over [0, width] x [0, height].
void ForEachCell(double width, double height, uint64_t seed, const std::function<void(double, double)>& visit) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> jitter(-0.35, 0.35);
  const double columns = std::max(std::round(width), 1.0), rows = std::max(std::round(height), 1.0);
  for (double row = 0.5; row < rows; ++row) {
    for (double column = 0.5; column < columns; ++column) {
      visit((column + jitter(random)) * width / columns, (row + jitter(random)) * height / rows);
    }
  }
}

// A flat face from `corner` along u and v, unit vectors, all of whose sides are edges.
void AddFace(const Vec3& corner, const Vec3& u, double width, const Vec3& v, double height, uint64_t seed,
             Solid& solid) {
  const Vec3 normal = curv::Cross(u, v);
  ForEachCell(width, height, seed, [&](double a, double b) {
    solid.Add(corner + a * u + b * v, normal, 0.0, std::min({a, width - a, b, height - b}));
  });
}

Solid Box(double points) {
  const double s = std::sqrt(points / 6.0);
  const Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  Solid solid;
  AddFace({0, 0, 0}, y, s, x, s, 1, solid);
  AddFace({0, 0, s}, x, s, y, s, 2, solid);
  AddFace({0, 0, 0}, x, s, z, s, 3, solid);
  AddFace({0, s, 0}, z, s, x, s, 4, solid);
  AddFace({0, 0, 0}, z, s, y, s, 5, solid);
  AddFace({s, 0, 0}, y, s, z, s, 6, solid);
  return solid;
}

// What two balls have in common: caps of half angle 50 degrees, so that faces meet at an edge of 80 degrees.
Solid Lens(double points) {
  const double half = 50.0 / 180.0 * std::numbers::pi;
  const double radius = std::sqrt(points / 2.0 / (2.0 * std::numbers::pi * (1.0 - std::cos(half))));
  const double golden = std::numbers::pi * (3.0 - std::sqrt(5.0));
  Solid solid;
  const double count = std::round(points / 2.0);
  for (const double side : {1.0, -1.0}) {
    for (double i = 0.5; i < count; ++i) {
      const double z = 1.0 - i / count * (1.0 - std::cos(half)), r = std::sqrt(1.0 - z * z), turn = golden * i * side;
      const Vec3 normal{r * std::cos(turn), r * std::sin(turn), side * z};
      const Vec3 center{0.0, 0.0, -side * radius * std::cos(half)};
      solid.Add(center + radius * normal, normal, 1.0 / radius, radius * (half - std::acos(z)));
    }
  }
  return solid;
}

// Two planes with a riser between them, open all around.
Solid Step(double points) {
  const double s = std::sqrt(points / 2.2), rise = 0.2 * s;
  Solid solid;
  ForEachCell(s, s, 1, [&](double a, double b) { solid.Add({a, b, 0}, {0, 0, 1}, 0.0, s - a); });
  ForEachCell(s, s, 2, [&](double a, double b) { solid.Add({s + a, b, rise}, {0, 0, 1}, 0.0, a); });
  ForEachCell(rise, s, 3, [&](double a, double b) { solid.Add({s, b, a}, {-1, 0, 0}, 0.0, std::min(a, rise - a)); });
  return solid;
}

// A piece of an outline: from `from` straight on to `to`, or around `center`, clockwise.
struct Piece {
  double from[2], to[2];
  bool is_arc;
  double center[2];
  bool is_edge_at_start;
};

// An extruded outline with corners of 34 to 90 degrees and a hollow that is a part of a cylinder, one end of which goes
// over into a flat face without an edge.
Solid Disk(double points) {
  const std::vector<Piece> pieces = {{{0, 0}, {4, 0}, false, {}, true},    {{4, 0}, {4, 1}, false, {}, true},
                                     {{4, 1}, {3, 2.5}, false, {}, true},  {{3, 2.5}, {1, 4.5}, true, {3, 4.5}, true},
                                     {{1, 4.5}, {1, 5}, false, {}, false}, {{1, 5}, {0, 5}, false, {}, true},
                                     {{0, 5}, {0, 0}, false, {}, true}};
  constexpr double kRadius = 2.0, kHeight = 3.0, kArea = 71.0;  // of the surface, nearly
  const double scale = std::sqrt(points / kArea);
  Solid solid;
  // Where the outline is, densely.
  struct Place {
    double x, y, nx, ny, mean;
  };
  const auto at = [&](const Piece& piece, double t) -> Place {
    if (piece.is_arc) {
      const double angle = std::numbers::pi * (1.5 - 0.5 * t), c = std::cos(angle), s = std::sin(angle);
      return {piece.center[0] + kRadius * c, piece.center[1] + kRadius * s, -c, -s, -0.5 / kRadius};
    }
    const double dx = piece.to[0] - piece.from[0], dy = piece.to[1] - piece.from[1], length = std::hypot(dx, dy);
    return {piece.from[0] + t * dx, piece.from[1] + t * dy, dy / length, -dx / length, 0.0};
  };
  const auto to_corner = [&](double x, double y) {
    double least = 1e300;
    for (const Piece& piece : pieces) {
      if (piece.is_edge_at_start) least = std::min(least, std::hypot(x - piece.from[0], y - piece.from[1]));
    }
    return least;
  };
  uint64_t seed = 1;
  std::vector<Place> outline;
  for (const Piece& piece : pieces) {
    const double length = piece.is_arc ? 0.5 * std::numbers::pi * kRadius
                                       : std::hypot(piece.to[0] - piece.from[0], piece.to[1] - piece.from[1]);
    ForEachCell(length * scale, kHeight * scale, seed++, [&](double a, double b) {
      const Place place = at(piece, a / (length * scale));
      const double to_edge = std::min({to_corner(place.x, place.y) * scale, b, kHeight * scale - b});
      solid.Add({place.x * scale, place.y * scale, b}, {place.nx, place.ny, 0.0}, place.mean / scale, to_edge);
    });
    for (int i = 0; i < 400; ++i) outline.push_back(at(piece, i / 400.0));
  }
  const auto is_inside = [&](double x, double y) {
    bool inside = false;
    for (size_t i = 0, j = outline.size() - 1; i < outline.size(); j = i++) {
      const Place &p = outline[i], &q = outline[j];
      if ((p.y > y) != (q.y > y) && x < (q.x - p.x) * (y - p.y) / (q.y - p.y) + p.x) inside = !inside;
    }
    return inside;
  };
  for (const double side : {1.0, -1.0}) {
    ForEachCell(4.0 * scale, 5.0 * scale, seed++, [&](double a, double b) {
      if (!is_inside(a / scale, b / scale)) return;
      double least = 1e300;
      for (const Place& place : outline) least = std::min(least, std::hypot(a - place.x * scale, b - place.y * scale));
      solid.Add({a, b, side > 0.0 ? kHeight * scale : 0.0}, {0, 0, side}, 0.0, least);
    });
  }
  return solid;
}

constexpr double kBands[] = {1.0, 2.0, 4.0, 8.0, 16.0, 1e300};
constexpr size_t kBandCount = std::size(kBands);

void PrintErrors(const char* what, const Solid& solid, const EstimationResult& result) {
  double sums[kBandCount] = {};
  size_t counts[kBandCount] = {}, failed = 0;
  double total = 0.0;
  for (size_t i = 0; i < solid.mean.size(); ++i) {
    const PointCurvature& point = result.field.points[i];
    if (point.status != PointStatus::kOk) {
      ++failed;
      continue;
    }
    size_t band = 0;
    while (solid.distance[i] > kBands[band]) ++band;
    sums[band] += std::abs(point.mean - solid.mean[i]);
    total += std::abs(point.mean - solid.mean[i]);
    ++counts[band];
  }
  absl::PrintF("   %-18s", what);
  for (size_t band = 0; band < kBandCount; ++band) {
    if (counts[band] == 0) {
      absl::PrintF(" %9s", "-");
    } else {
      absl::PrintF(" %9.2g", sums[band] / static_cast<double>(counts[band]));
    }
  }
  absl::PrintF(" | %9.2g  failed %d\n", total / static_cast<double>(solid.mean.size() - failed), failed);
}

// How all solids are estimated.
struct EdgeWay {
  uint64_t seed;
  bool makes_normals;
  WorkerPool& pool;
};

void PrintSolid(const std::string& name, const Solid& exact, double position_noise, double normal_noise,
                const EdgeWay& way) {
  Solid solid = exact;
  curv::AddPositionNoise(position_noise, way.seed, solid.samples.positions);
  if (normal_noise > 0.0) curv::AddNormalNoise(normal_noise, way.seed, solid.samples.normals);
  absl::PrintF("%s, %d points, noise %g spacings / %g\n", name, solid.mean.size(), position_noise, normal_noise);
  const auto estimate = [&](const char* what, const EstimatorOptions& options) {
    PrintErrors(what, solid, EstimateSamples(solid.samples, options, way.makes_normals, way.pool));
  };
  estimate("avg-hexagram 16", {.neighborhood = NeighborCount{16}});
  estimate("avg-hexagram 50", {.neighborhood = NeighborCount{50}});
  estimate("auto per cloud", {.estimator = kAutomaticEstimator, .neighborhood = AutomaticScale{.per_cloud = true}});
  estimate("auto", {.estimator = kAutomaticEstimator, .neighborhood = AutomaticScale{}});
  std::fflush(stdout);
}

int Main(int argc, char** argv) {
  double points = 10'000.0;
  uint64_t seed = 1;
  bool makes_normals = false;
  std::vector<double> position_noise = {0.0, 0.2}, normal_noise = {0.0, 0.1};
  CLI::App app("Errors of automatic estimates by the distance to a sharp edge");
  app.add_option("--points", points, "Of each solid, nearly");
  app.add_option("--seed", seed, "Of the noise");
  app.add_option("--position-noise", position_noise, "In spacings")->delimiter(',');
  app.add_option("--normal-noise", normal_noise, "Standard deviations")->delimiter(',');
  app.add_flag("--make-normals", makes_normals, "Normals are made of the positions, in place of the samples' own");
  CLI11_PARSE(app, argc, argv);
  if (makes_normals) normal_noise = {0.0};
  WorkerPool pool(2);
  const EdgeWay way{seed, makes_normals, pool};
  absl::PrintF("mean |H error| in 1 / spacing, at most so many spacings from an edge:\n   %-18s", "");
  for (const double band : kBands) band < 1e6 ? absl::PrintF(" %9g", band) : absl::PrintF(" %9s", "beyond");
  absl::PrintF(" | %9s\n", "all");
  const std::pair<const char*, Solid (*)(double)> solids[] = {
      {"box", Box}, {"lens", Lens}, {"step", Step}, {"disk", Disk}};
  for (const auto& [name, make] : solids) {
    const Solid solid = make(points);
    for (const double position : position_noise) {
      for (const double normal : normal_noise) PrintSolid(name, solid, position, normal, way);
    }
  }
  return 0;
}

}  // namespace
}  // namespace curvd::bench

int main(int argc, char** argv) { return curvd::bench::Main(argc, argv); }
