// Errors of every estimator on the paper's clouds: what Figure 4 and the supplement show, as rows of a CSV file.
//
// Each row is one estimate of one cloud. Columns: the cloud (surface, sampling, points, position_noise, normal_noise,
// realization), K and method, then the errors (bench/paper/errors.h). Rows come in the order of the grid.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "bench/paper/errors.h"
#include "bench/paper/grid.h"
#include "bench/paper/methods.h"
#include "core/job/estimation_job.h"

namespace curvd::bench {
namespace {

constexpr char kHeader[] =
    "surface,sampling,points,position_noise,normal_noise,realization,K,method,H_mae,H_rmse,H_q25,H_med,H_q75,"
    "G_mae,G_rmse,G_q25,G_med,G_q75,k1_rmse,k2_rmse,dir_med_deg,n_ok,n_fail\n";

struct Flags {
  bool tiny = false;
  bool quick = false;
  std::string paper_folder = PAPER_CLOUD_DIR;
  std::string out;
};

Flags ParseFlags(int argc, char** argv) {
  Flags flags;
  CLI::App app("Errors of every estimator on the paper's clouds");
  app.add_flag("--tiny", flags.tiny, "Seconds: shows that it runs");
  app.add_flag("--quick", flags.quick, "Minutes: small clouds, few neighbor counts");
  app.add_option("--paper-clouds", flags.paper_folder, "Folder of the paper's clouds, used where they exist")
      ->capture_default_str();
  app.add_option("--out", flags.out, "The CSV file")->required();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    std::exit(app.exit(error));
  }
  return flags;
}

std::string Cells(const QuantityErrors& e) {
  return absl::StrFormat("%.6e,%.6e,%.6e,%.6e,%.6e", e.mean, e.rms, e.lower_quartile, e.median, e.upper_quartile);
}

std::string Row(const GridCloud& cloud, size_t points, uint32_t k, const std::string& method, const FieldErrors& e) {
  return absl::StrFormat("%s,%s,%d,%g,%g,%d,%d,%s,%s,%s,%.6e,%.6e,%.4f,%d,%d\n", cloud.surface, cloud.sampling, points,
                         cloud.noise.position, cloud.noise.normal, cloud.realization, k, method, Cells(e.mean),
                         Cells(e.gaussian), e.k1.rms, e.k2.rms, e.direction_median, e.estimated, e.failed);
}

// Rows of one cloud: every method with every neighbor count.
std::string Evaluate(const GridCloud& cloud, WorkerPool& pool) {
  const Samples samples = Perturbed(cloud.undisturbed(), cloud.noise.position, cloud.noise.normal, cloud.realization);
  std::string rows;
  for (uint32_t k : cloud.neighbor_counts) {
    for (const Method& method : PaperMethods()) {
      const auto result = EstimateCurvature(ToCloud(samples), method.WithNeighbors(k), pool);
      if (!result.ok()) {
        std::fprintf(stderr, "%s, K = %u: %s\n", method.name.c_str(), k, result.status().ToString().c_str());
        std::exit(1);
      }
      const FieldErrors errors = MeasureErrors(result->field.points.span(), samples.truth);
      rows += Row(cloud, samples.size(), k, method.name, errors);
    }
  }
  return rows;
}

// Clouds are evaluated side by side, one thread each, the largest first; the result depends on neither.
std::vector<std::string> EvaluateAll(const std::vector<GridCloud>& grid) {
  std::vector<size_t> order(grid.size());
  for (size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return grid[a].points > grid[b].points; });
  std::vector<std::string> rows(grid.size());
  std::atomic<size_t> next{0};
  const auto work = [&] {
    WorkerPool pool(1);
    for (size_t i = next++; i < order.size(); i = next++) {
      const GridCloud& cloud = grid[order[i]];
      rows[order[i]] = Evaluate(cloud, pool);
      absl::FPrintF(stderr, "%d of %d: %s %s %d, noise %g %g\n", i + 1, grid.size(), cloud.surface, cloud.sampling,
                    cloud.points, cloud.noise.position, cloud.noise.normal);
    }
  };
  std::vector<std::thread> threads;
  for (unsigned i = 0; i < std::max(1u, std::thread::hardware_concurrency()); ++i) threads.emplace_back(work);
  for (std::thread& thread : threads) thread.join();
  return rows;
}

int Main(const Flags& flags) {
  const GridSize size = flags.tiny ? GridSize::kTiny : flags.quick ? GridSize::kQuick : GridSize::kWhole;
  const std::vector<std::string> rows = EvaluateAll(PaperGrid(size, flags.paper_folder));
  std::ofstream file(flags.out);
  file << kHeader;
  for (const std::string& row : rows) file << row;
  file.close();
  if (file) return 0;
  std::fprintf(stderr, "cannot write %s\n", flags.out.c_str());
  return 1;
}

}  // namespace
}  // namespace curvd::bench

int main(int argc, char** argv) { return curvd::bench::Main(curvd::bench::ParseFlags(argc, argv)); }
