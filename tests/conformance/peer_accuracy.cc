// Compares our mean errors with those measured for peers on the paper's clouds: the paper authors' code, CGAL's jets
// and Ponca's algebraic shape operator. Prints a table.
//
//   peer_accuracy MEASURED_CSV CLOUD_DIR [EVERY]
//
// EVERY (1): of all rows that can be compared, each EVERYth is.
//
// MEASURED_CSV holds the peers' errors (columns cloud, N, sig_eps, sig_xi, K, method, H_mae, ..., G_mae, ...);
// CLOUD_DIR holds the clouds as CLOUD_NNNNNN.pts. Exit code 1 if any of our mean errors exceeds its bound: 1.03 times
// the peer's, 1.15 times for the hexagram, whose search differs (docs/numerics.md), or 1.02 times for the algebraic
// shape operator. Fits to few noisy points err without bound, and the mean error of one realization of the noise, which
// is what the peers' figures are of, moves by more than these bounds: a fit's row passes if its excess is within three
// standard deviations of that, and its mean over all rows must keep the bound.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include "client/io/oriented_cloud.h"
#include "client/io/table_file.h"
#include "client/surfaces/noise.h"
#include "client/surfaces/surface.h"
#include "core/job/estimation_job.h"

namespace {

// What a peer's estimator corresponds to here.
struct Method {
  const char* peer;
  const char* name;
  std::string_view estimator;
  uint32_t triangle_count;
  uint32_t jet_degree;
  double bound;
  bool is_fit;
};
constexpr Method kMethods[] = {
    {"RefU10", "uniform L=10", "uniform", 10, 2, 1.03, false},
    {"RefU100", "uniform L=100", "uniform", 100, 2, 1.03, false},
    {"RefHex", "hexagram", "hexagram", 100, 2, 1.15, false},
    {"RefAvgHex", "avg-hexagram", "avg-hexagram", 100, 2, 1.03, false},
    {"CGALJet4", "jet degree 4", "jet", 100, 4, 1.03, true},
    {"CGALJet2", "jet degree 2", "jet", 100, 2, 1.03, true},
    {"PoncaASO", "aso", "aso", 100, 2, 1.02, true},
};

struct CloudKey {
  std::string surface;
  int points;
  double position_noise;
  double normal_noise;
  auto operator<=>(const CloudKey&) const = default;
};

struct MeanErrors {
  double mean = 0.0;
  double gaussian = 0.0;
};

struct Measured {
  uint32_t neighbor_count;
  const Method* method;
  MeanErrors errors;
};

// Each `every`th of the rows of the CSV whose methods have a counterpart, by cloud.
std::map<CloudKey, std::vector<Measured>> LoadMeasured(const char* path, int every) {
  int count = 0;
  std::map<CloudKey, std::vector<Measured>> measured;
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::vector<std::string> cells;
    std::istringstream stream(line);
    for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
    if (cells.size() < 10) continue;
    const auto method =
        std::find_if(std::begin(kMethods), std::end(kMethods), [&](const Method& m) { return cells[5] == m.peer; });
    if (method == std::end(kMethods) || count++ % every != 0) continue;
    measured[{cells[0], std::stoi(cells[1]), std::stod(cells[2]), std::stod(cells[3])}].push_back(
        {static_cast<uint32_t>(std::stoi(cells[4])), method, {std::stod(cells[6]), std::stod(cells[9])}});
  }
  return measured;
}

// Samples with the exact curvature at each, before noise.
struct Samples {
  std::vector<curv::Vec3> positions;
  std::vector<curv::Vec3> normals;
  std::vector<curv::SurfaceGeometry> truth;
};

std::optional<Samples> LoadSamples(const std::string& directory, const CloudKey& key) {
  char name[64];
  std::snprintf(name, sizeof(name), "/%s_%06d.pts", key.surface.c_str(), key.points);
  const auto table = curv::LoadTable(directory + name);
  const auto surface = curv::MakeSurface(key.surface);
  if (!table.ok() || !surface.ok()) return std::nullopt;
  const auto cloud = curv::ExtractCloud(*table);
  if (!cloud.ok()) return std::nullopt;
  Samples samples;
  std::visit(
      [&](const auto& packed) {
        for (size_t i = 0; i + 2 < packed.positions.size(); i += 3) {
          samples.positions.push_back({packed.positions[i], packed.positions[i + 1], packed.positions[i + 2]});
          samples.normals.push_back({packed.normals[i], packed.normals[i + 1], packed.normals[i + 2]});
          samples.truth.push_back((*surface)->At((*surface)->Project(samples.positions.back())));
        }
      },
      *cloud);
  return samples;
}

std::vector<float> Pack(const std::vector<curv::Vec3>& vectors) {
  std::vector<float> packed;
  packed.reserve(3 * vectors.size());
  for (const curv::Vec3& v : vectors) {
    for (int axis = 0; axis < 3; ++axis) packed.push_back(static_cast<float>(v[axis]));
  }
  return packed;
}

std::string_view Bytes(const std::vector<float>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float)};
}

constexpr uint64_t kRealizations = 4;
// The errors of an estimate that failed: over any bound.
constexpr MeanErrors kNoEstimate{1e9, 1e9};

// Mean and standard deviation of one realization's error.
class Spread {
 public:
  void Add(double error) {
    sum_ += error;
    squares_ += error * error;
    ++count_;
  }
  double mean() const { return sum_ / count_; }
  double deviation() const {
    return count_ > 1 ? std::sqrt(std::max(0.0, squares_ - count_ * mean() * mean()) / (count_ - 1)) : 0.0;
  }

 private:
  double sum_ = 0.0;
  double squares_ = 0.0;
  int count_ = 0;
};

struct ErrorSpread {
  Spread mean;
  Spread gaussian;
};

class AccuracyTable {
 public:
  // Averages our errors over several realizations of the noise: neighborhoods overlap, so one alone is off by 3 to 7 %
  // at K = 200 and above. The peers' figures are of one.
  void Compare(const CloudKey& key, const Samples& samples, const std::vector<Measured>& rows) {
    const bool noisy = key.position_noise > 0.0 || key.normal_noise > 0.0;
    const uint64_t realizations = noisy ? kRealizations : 1;
    std::vector<ErrorSpread> ours(rows.size());
    for (uint64_t seed = 1; seed <= realizations; ++seed) {
      Samples perturbed = samples;
      curv::AddPositionNoise(key.position_noise, seed, perturbed.positions);
      curv::AddNormalNoise(key.normal_noise, seed, perturbed.normals);
      const std::vector<float> positions = Pack(perturbed.positions), normals = Pack(perturbed.normals);
      for (size_t i = 0; i < rows.size(); ++i) {
        const MeanErrors errors = Estimate(positions, normals, samples.truth, rows[i]);
        ours[i].mean.Add(errors.mean);
        ours[i].gaussian.Add(errors.gaussian);
      }
    }
    for (size_t i = 0; i < rows.size(); ++i) Print(key, rows[i], ours[i]);
  }

  void PrintWorst() const {
    std::printf("\nours / theirs   %17s %17s\n%-14s %8s %8s %8s %8s %8s\n", "mean", "worst", "estimator", "H", "G", "H",
                "G", "bound");
    for (const auto& [method, ratios] : ratios_) {
      std::printf("%-14s %8.3f %8.3f %8.3f %8.3f %8.2f %s\n", method->name, ratios.MeanOfH(), ratios.MeanOfG(),
                  ratios.worst.mean, ratios.worst.gaussian, method->bound, ratios.Over(*method) ? "OVER" : "");
    }
    std::printf("rows: %d, over their bound: %d\n", rows_, misses_);
  }

  int rows() const { return rows_; }
  // Rows over their bound, and estimators whose mean over all rows is.
  int misses() const {
    return misses_ + static_cast<int>(std::count_if(ratios_.begin(), ratios_.end(),
                                                    [](const auto& entry) { return entry.second.Over(*entry.first); }));
  }

 private:
  // Of one estimator over all rows.
  struct Ratios {
    MeanErrors worst;
    MeanErrors logarithms;
    int rows = 0;

    double MeanOfH() const { return std::exp(logarithms.mean / rows); }
    double MeanOfG() const { return std::exp(logarithms.gaussian / rows); }
    bool Over(const Method& method) const { return std::max(MeanOfH(), MeanOfG()) > method.bound; }
  };

  MeanErrors Estimate(const std::vector<float>& positions, const std::vector<float>& normals,
                      const std::vector<curv::SurfaceGeometry>& truth, const Measured& row) {
    curvd::Cloud cloud;
    if (!cloud.Append(Bytes(positions), Bytes(normals)).ok() || !cloud.Finish().ok()) return kNoEstimate;
    curvd::EstimatorOptions options;
    options.estimator = row.method->estimator;
    options.triangle_count = row.method->triangle_count;
    options.jet_degree = row.method->jet_degree;
    options.neighborhood = curvd::NeighborCount{row.neighbor_count};
    const auto result = curvd::EstimateCurvature(std::move(cloud), options, pool_);
    if (!result.ok()) return kNoEstimate;
    MeanErrors errors;
    size_t done = 0;
    for (size_t i = 0; i < truth.size(); ++i) {
      const curvd::PointCurvature& point = result->field.points[i];
      if (point.status != curvd::PointStatus::kOk) continue;
      errors.mean += std::abs(point.mean - truth[i].mean);
      errors.gaussian += std::abs(point.gaussian - truth[i].gaussian);
      ++done;
    }
    // A fit that finds no surface in the noise says so; such a point counts with the peer's mean error.
    if (done < truth.size() * (row.method->is_fit ? 0.9 : 0.999)) {
      std::printf("only %zu of %zu points estimated\n", done, truth.size());
      return kNoEstimate;
    }
    const double share = static_cast<double>(done) / static_cast<double>(truth.size());
    return {errors.mean / truth.size() + (1.0 - share) * row.errors.mean,
            errors.gaussian / truth.size() + (1.0 - share) * row.errors.gaussian};
  }

  // Whether an error is over the bound by more than chance explains, if the method is a fit.
  static bool IsOver(const Method& method, const Spread& ours, double theirs) {
    constexpr double kDeviations = 3.0;
    const double chance = method.is_fit ? kDeviations * ours.deviation() : 0.0;
    return ours.mean() > method.bound * theirs + chance;
  }

  void Print(const CloudKey& key, const Measured& row, const ErrorSpread& spread) {
    const MeanErrors ours{spread.mean.mean(), spread.gaussian.mean()};
    const MeanErrors ratio{ours.mean / row.errors.mean, ours.gaussian / row.errors.gaussian};
    const bool over =
        IsOver(*row.method, spread.mean, row.errors.mean) || IsOver(*row.method, spread.gaussian, row.errors.gaussian);
    std::printf("%-8s %6d %4.1f %4.1f %4u %-14s %10.3e %10.3e %6.3f %10.3e %10.3e %6.3f %s\n", key.surface.c_str(),
                key.points, key.position_noise, key.normal_noise, row.neighbor_count, row.method->name, ours.mean,
                row.errors.mean, ratio.mean, ours.gaussian, row.errors.gaussian, ratio.gaussian, over ? "OVER" : "");
    Ratios& ratios = ratios_[row.method];
    ratios.worst.mean = std::max(ratios.worst.mean, ratio.mean);
    ratios.worst.gaussian = std::max(ratios.worst.gaussian, ratio.gaussian);
    ratios.logarithms.mean += std::log(ratio.mean);
    ratios.logarithms.gaussian += std::log(ratio.gaussian);
    ++ratios.rows;
    ++rows_;
    misses_ += over;
  }

  curvd::WorkerPool pool_{static_cast<int>(std::max(1u, std::thread::hardware_concurrency()))};
  std::map<const Method*, Ratios> ratios_;
  int rows_ = 0;
  int misses_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
  const int every = argc == 4 ? std::atoi(argv[3]) : 1;
  if (argc < 3 || argc > 4 || every < 1) {
    std::fprintf(stderr, "usage: peer_accuracy MEASURED_CSV CLOUD_DIR [EVERY], EVERY being 1 or more\n");
    return 2;
  }
  std::printf("%-8s %6s %4s %4s %4s %-14s %10s %10s %6s %10s %10s %6s\n", "cloud", "N", "pos", "nrm", "K", "estimator",
              "H ours", "H theirs", "ratio", "G ours", "G theirs", "ratio");
  AccuracyTable table;
  for (const auto& [key, rows] : LoadMeasured(argv[1], every)) {
    const std::optional<Samples> samples = LoadSamples(argv[2], key);
    if (!samples.has_value()) {
      std::fprintf(stderr, "no cloud %s with %d points in %s\n", key.surface.c_str(), key.points, argv[2]);
      return 2;
    }
    table.Compare(key, *samples, rows);
  }
  table.PrintWorst();
  if (table.rows() == 0) return 2;
  return table.misses() == 0 ? 0 : 1;
}
