// How often the intervals of standard errors hold the truth.
//
// Each row is one cloud, estimated with standard errors: of the points with status ok, the percentage whose true H, k1
// and k2 lie within 1.645 standard errors of the estimate, where 90 is meant; and how wide the intervals are in the
// middle, over what would have held nine tenths of the errors.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_format.h"
#include "bench/paper/height_errors.h"
#include "bench/paper/normal_flags.h"
#include "bench/paper/samples.h"
#include "core/job/estimation_job.h"

namespace curvd::bench {
namespace {

// A Gaussian lies within so many standard deviations nine times in ten.
constexpr double kNineTenths = 1.645;

struct Flags {
  std::vector<std::string> surfaces = {"goursat", "torus", "ellipsoid", "cylinder", "saddle", "plane", "sphere"};
  std::vector<size_t> points = {10'000, 25'000, 50'000};
  std::vector<double> position_noise = {0.0, 0.1, 0.2};
  std::vector<double> normal_noise = {0.0, 0.1, 0.2};
  uint64_t seed = 1;
  std::string sampling = "even";
  std::string estimator = "auto";
  uint32_t neighbor_count = 0;
  bool per_cloud = false;
  HeightFlags heights;
  NormalFlags normals;
};

Flags ParseFlags(int argc, char** argv) {
  Flags flags;
  CLI::App app("How often the intervals of standard errors hold the truth");
  app.add_option("--surfaces", flags.surfaces, "Names of surfaces, as curv generate or held_out_surfaces.h has them")
      ->delimiter(',');
  app.add_option("--points", flags.points, "Sizes of clouds")->delimiter(',');
  app.add_option("--position-noise", flags.position_noise, "In the paper's unit: 1/20 of the surface's largest extent")
      ->delimiter(',');
  app.add_option("--normal-noise", flags.normal_noise, "Standard deviations")->delimiter(',');
  app.add_option("--seed", flags.seed, "Of samples and noise");
  app.add_option("--sampling", flags.sampling, "How points lie: even, thinned, falling, random or scanned")
      ->check(CLI::IsMember(std::vector<std::string>(std::begin(kSampleSpreads), std::end(kSampleSpreads))));
  app.add_option("--estimator", flags.estimator, "auto, or one that the choice knows");
  app.add_option("--k", flags.neighbor_count, "A fixed number of neighbors; 0: automatic");
  app.add_flag("--per-cloud", flags.per_cloud, "One choice for all points");
  AddHeightFlags(app, flags.heights);
  AddNormalFlags(app, flags.normals);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    std::exit(app.exit(error));
  }
  return flags;
}

struct Coverage {
  double percent;  // of the intervals that hold the truth
  double width;    // median, over the one that holds nine tenths of the errors
};

Coverage CoverageOf(std::vector<double> errors, std::vector<double> widths) {
  size_t held = 0;
  for (size_t i = 0; i < errors.size(); ++i) held += errors[i] <= widths[i] ? 1 : 0;
  const auto at = [](std::vector<double>& values, double share) {
    const auto place = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), place, values.end());
    return *place;
  };
  return {100.0 * static_cast<double>(held) / static_cast<double>(errors.size()), at(widths, 0.5) / at(errors, 0.9)};
}

struct Row {
  size_t with_errors = 0, without = 0;  // points
  std::array<Coverage, 3> coverage{};   // of H, k1 and k2
  ScaleReport report;
};

Row Measure(const Samples& samples, const EstimatorOptions& options, bool makes_normals, WorkerPool& pool) {
  const EstimationResult result = EstimateSamples(samples, options, makes_normals, pool);
  Row row;
  if (result.scale_report.has_value()) row.report = *result.scale_report;
  std::array<std::vector<double>, 3> errors, widths;
  for (size_t i = 0; i < samples.size(); ++i) {
    const PointCurvature& point = result.field.points[i];
    const PointChoice& choice = result.choices[i];
    if (!(choice.mean_error >= 0.0f)) {
      ++row.without;
      continue;
    }
    ++row.with_errors;
    const curv::SurfaceGeometry& truth = samples.truth[i];
    const double found[3] = {point.mean, point.k1, point.k2}, wanted[3] = {truth.mean, truth.k1, truth.k2};
    const double sure[3] = {choice.mean_error, choice.k1_error, choice.k2_error};
    for (size_t q = 0; q < 3; ++q) {
      errors[q].push_back(std::abs(found[q] - wanted[q]));
      widths[q].push_back(kNineTenths * sure[q]);
    }
  }
  for (size_t q = 0; q < 3 && row.with_errors > 0; ++q) row.coverage[q] = CoverageOf(errors[q], widths[q]);
  return row;
}

EstimatorOptions OptionsOf(const Flags& flags) {
  EstimatorOptions options;
  options.estimator = flags.estimator;
  if (flags.estimator == "jet") options.jet_degree = 4;
  options.neighborhood = AutomaticScale{.per_cloud = flags.per_cloud};
  if (flags.neighbor_count != 0) options.neighborhood = NeighborCount{flags.neighbor_count};
  options.returns_choice = true;
  return options;
}

void PrintExtremes(const char* title, std::array<std::vector<double>, 3>& percents) {
  if (percents[0].empty()) return;
  absl::PrintF("%s:", title);
  for (size_t q = 0; q < 3; ++q) {
    std::sort(percents[q].begin(), percents[q].end());
    const auto within =
        std::count_if(percents[q].begin(), percents[q].end(), [](double p) { return p >= 80.0 && p <= 97.0; });
    absl::PrintF("  %s %.0f to %.0f, median %.0f, within 80 to 97: %d of %d",
                 q == 0   ? "H"
                 : q == 1 ? "k1"
                          : "k2",
                 percents[q].front(), percents[q].back(), percents[q][percents[q].size() / 2], within,
                 percents[q].size());
  }
  absl::PrintF("\n");
}

int Main(const Flags& flags) {
  WorkerPool pool(static_cast<int>(std::max(1u, std::thread::hardware_concurrency())));
  absl::PrintF("%-10s %6s %5s %5s | %5s %5s %5s | %5s %5s %5s | %9s %7s | %s\n", "cloud", "points", "pos", "nrm", "H",
               "k1", "k2", "wH", "wk1", "wk2", "sigma", "normals", "without");
  std::array<std::vector<double>, 3> noisy, exact;
  for (const std::string& surface : flags.surfaces) {
    const double unit = NoiseUnit(surface);
    for (const size_t points : flags.points) {
      const Samples samples =
          WithHeightErrors(SampleAs(flags.sampling, surface, points, flags.seed), flags.heights, flags.seed);
      for (const double position : flags.position_noise) {
        for (const double normal : flags.normal_noise) {
          const Samples perturbed =
              WithNormals(Perturbed(samples, position * unit, normal, flags.seed), flags.normals, pool);
          const Row row = Measure(perturbed, OptionsOf(flags), flags.normals.makes, pool);
          const auto& c = row.coverage;
          absl::PrintF("%-10s %6d %5g %5g | %5.1f %5.1f %5.1f | %5.2f %5.2f %5.2f | %9.3g %7.4f | %d\n", surface,
                       samples.size(), position, normal, c[0].percent, c[1].percent, c[2].percent, c[0].width,
                       c[1].width, c[2].width, row.report.sigma / unit, row.report.normal_sigma.value_or(-1.0),
                       row.without);
          std::fflush(stdout);
          if (row.with_errors == 0) continue;
          auto& percents = position > 0.0 || normal > 0.0 ? noisy : exact;
          for (size_t q = 0; q < 3; ++q) percents[q].push_back(c[q].percent);
        }
      }
    }
  }
  PrintExtremes("with noise", noisy);
  PrintExtremes("exact", exact);
  return 0;
}

}  // namespace
}  // namespace curvd::bench

int main(int argc, char** argv) { return curvd::bench::Main(curvd::bench::ParseFlags(argc, argv)); }
