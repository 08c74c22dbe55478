// Sides of normals that are made of positions alone: how many are wrong, and whether the certificate tells.
//
// Each row is one cloud of points whose spacing is 1 on average. An open cloud may have either side, but one only.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_format.h"
#include "bench/paper/sides/bodies.h"
#include "bench/paper/sides/patch_samples.h"
#include "bench/paper/sides/patches.h"
#include "bench/paper/sides/plates.h"
#include "client/surfaces/noise.h"
#include "client/surfaces/vec3.h"
#include "core/job/normals_job.h"

namespace curvd::bench {
namespace {

using curv::Vec3;

struct Found {
  double flipped;
  NormalReport report;
};

std::vector<float> Packed(const std::vector<Vec3>& positions) {
  std::vector<float> packed;
  for (const Vec3& p : positions) {
    for (const double c : {p.x, p.y, p.z}) packed.push_back(static_cast<float>(c));
  }
  return packed;
}

Found Try(const Shape& shape, WorkerPool& pool, const char* dump) {
  const std::vector<float> positions = Packed(shape.samples.positions);
  Cloud cloud(ScalarType::kFloat32, InvalidPointPolicy::kReject, NormalsInput::kAbsent);
  absl::Status status =
      cloud.Append({reinterpret_cast<const char*>(positions.data()), positions.size() * sizeof(float)}, {});
  if (status.ok()) status = cloud.Finish();
  NormalOptions options;
  options.source = NormalSource::kEstimate;
  auto made = MakeNormals(std::move(cloud), options, pool);
  if (!made.ok()) {
    std::fprintf(stderr, "%s\n", made.status().ToString().c_str());
    std::exit(1);
  }
  double flipped = 0.0, count = 0.0;
  std::FILE* file = dump != nullptr ? std::fopen(dump, "w") : nullptr;
  for (size_t i = 0; i < shape.samples.positions.size(); ++i) {
    const PointNormal& point = made->normals[i];
    const Vec3 normal{point.normal[0], point.normal[1], point.normal[2]};
    const double dot = curv::Dot(normal, shape.samples.normals[i]);
    if (file != nullptr) {
      const Vec3 p = shape.samples.positions[i], t = shape.samples.normals[i];
      std::fprintf(file, "%g %g %g %g %g %g %g %g %g %d\n", p.x, p.y, p.z, t.x, t.y, t.z, normal.x, normal.y, normal.z,
                   static_cast<int>(point.status));
    }
    if (point.status != PointStatus::kOk) continue;
    flipped += dot < 0.0 ? 1.0 : 0.0;
    ++count;
  }
  if (file != nullptr) std::fclose(file);
  double share = flipped / count;
  if (shape.is_open) share = std::min(share, 1.0 - share);
  return {share, made->report};
}

struct Totals {
  int clouds = 0, wrong = 0, missed = 0, false_alarms = 0, right = 0;
};

void Report(const Shape& shape, uint64_t seed, double noise, WorkerPool& pool, const char* dump, Totals& totals) {
  const Found found = Try(shape, pool, dump);
  const NormalReport& r = found.report;
  const bool is_wrong = found.flipped > 0.02, is_doubtful = r.is_doubtful();
  ++totals.clouds;
  totals.wrong += is_wrong;
  totals.missed += is_wrong && !is_doubtful;
  totals.right += found.flipped <= 0.005;
  totals.false_alarms += found.flipped <= 0.005 && is_doubtful;
  absl::PrintF(
      "%-40s %7d %3d %5.2f  %6.2f %% %6.3f of %5.3f %-8s %5s %4d  %d/%d closed %.2f repaired %d turned %.4f opposed "
      "%.3f torn %.4f %s\n",
      shape.name, shape.samples.positions.size(), seed, noise, 100.0 * found.flipped, r.certificate.value_or(-1.0),
      r.max_trusted_certificate, is_doubtful ? "doubtful" : "", std::string(NormalMethodName(*r.method)),
      r.neighbor_count, r.closed_piece_count, r.piece_count, r.closed_area_share, r.repaired_count,
      r.turned_share.value_or(-1.0), r.opposed_share.value_or(-1.0), r.torn_share.value_or(-1.0),
      is_wrong && !is_doubtful                ? "MISSED"
      : found.flipped <= 0.005 && is_doubtful ? "FALSE"
                                              : "");
  std::fflush(stdout);
}

int Main(int argc, char** argv) {
  CLI::App app("Sides of normals made of positions: how many are wrong, and whether the certificate tells");
  std::string only, dump;
  double added_noise = 0.0;
  bool is_check = false, bodies = false, plates = false, shells = false, noisy = false, is_apart = false;
  std::vector<size_t> sizes;
  std::vector<double> levels;
  std::vector<uint64_t> seeds = {1};
  app.add_flag("--plates", plates, "Thin closed plates");
  app.add_flag("--shells", shells, "Thin bodies that are round: lenses, hollow balls, pots");
  app.add_flag("--bodies", bodies, "Thin bodies of other kinds");
  app.add_option("--noise", added_noise, "Noise of plates, shells and bodies, in spacings");
  app.add_flag("--noisy", noisy, "Small noisy clouds");
  app.add_flag("--apart", is_apart, "Shells and noisy clouds of points that keep apart, before noise");
  app.add_flag("--check", is_check, "Clouds by which nothing was chosen");
  app.add_option("--sizes", sizes, "Points");
  app.add_option("--levels", levels, "Noise of noisy clouds, thickness of plates and shells; in spacings");
  app.add_option("--seeds", seeds, "Of the clouds");
  app.add_option("--only", only, "Part of the name of the clouds that are tried");
  app.add_option("--dump", dump, "File for the last cloud: positions, true normals, normals, status");
  CLI11_PARSE(app, argc, argv);
  WorkerPool pool(2);
  Totals totals;
  const auto try_it = [&](Shape shape, uint64_t seed, double noise) {
    if (noise == 0.0 && added_noise > 0.0) {
      noise = added_noise;
      curv::AddPositionNoise(noise, seed, shape.samples.positions);
    }
    if (shape.name.find(only) == std::string::npos) return;
    Report(shape, seed, noise, pool, dump.empty() ? nullptr : dump.c_str(), totals);
  };
  if (plates) {
    const std::vector<std::string> outlines = is_check ? std::vector<std::string>{"triangle", "strip", "star"}
                                                       : std::vector<std::string>{"square", "disk", "bracket"};
    for (const size_t points : sizes.empty() ? std::vector<size_t>{5000, 20'000} : sizes) {
      for (const std::string& outline : outlines) {
        for (const double thickness : levels.empty() ? std::vector<double>{0.7, 1.0, 1.5, 2.0, 3.0} : levels) {
          for (const Sampling sampling : {Sampling::kShaken, Sampling::kRandom, Sampling::kLattice}) {
            for (const uint64_t seed : seeds) {
              Shape plate = Plate(outline, points, thickness, sampling, seed);
              if (seed % 2 == 0 || is_check) Tilt(0.3 + static_cast<double>(seed), plate.samples);
              try_it(plate, seed, 0.0);
            }
          }
        }
      }
    }
  }
  if (shells) {
    for (const size_t points : sizes.empty() ? std::vector<size_t>{900, 5000, 20'000} : sizes) {
      for (const double thickness : levels.empty() ? std::vector<double>{2.0, 3.0, 4.0, 6.0} : levels) {
        for (const Patch& body : Shells(points, thickness, is_check)) {
          for (const uint64_t seed : seeds) {
            Shape shell = SampleOf(body, points, seed, is_apart);
            Tilt(0.3 + static_cast<double>(seed), shell.samples);
            try_it(shell, seed, 0.0);
          }
        }
      }
    }
  }
  if (bodies) {
    for (const size_t points : sizes.empty() ? std::vector<size_t>{900, 5000} : sizes) {
      for (const double thickness : levels.empty() ? std::vector<double>{0.7, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0} : levels) {
        for (const Patch& body : Bodies(points, thickness)) {
          for (const uint64_t seed : seeds) {
            Shape shape = SampleOf(body, points, seed, is_apart);
            Tilt(0.3 + static_cast<double>(seed), shape.samples);
            try_it(std::move(shape), seed, 0.0);
          }
        }
      }
    }
  }
  if (noisy) {
    for (const size_t points : sizes.empty() ? std::vector<size_t>{300, 1000, 3000, 10'000} : sizes) {
      for (const Patch& patch : Patches(is_check)) {
        for (const double noise : levels.empty() ? std::vector<double>{0.0, 0.3, 0.7, 1.0, 1.5} : levels) {
          for (const uint64_t seed : seeds) {
            Shape cloud = SampleOf(patch, points, seed, is_apart);
            if (noise > 0.0) curv::AddPositionNoise(noise, seed, cloud.samples.positions);
            try_it(cloud, seed, noise);
          }
        }
      }
    }
  }
  absl::PrintF(
      "%d clouds; %d of them with more than 2 %% turned, %d of these without a warning; %d with at most 0.5 %%, %d of "
      "these with one\n",
      totals.clouds, totals.wrong, totals.missed, totals.right, totals.false_alarms);
  return 0;
}

}  // namespace
}  // namespace curvd::bench

int main(int argc, char** argv) { return curvd::bench::Main(argc, argv); }
