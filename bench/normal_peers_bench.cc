// Normals of positions alone beside those of PCL and Open3D: how exact they are, and what they cost.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "bench/clouds.h"
#include "bench/flags.h"
#include "bench/peers/normal_peers.h"
#include "bench/stopwatch.h"
#include "bench/table.h"
#include "client/surfaces/noise.h"
#include "core/job/normals_job.h"

namespace curvd::bench {
namespace {

// The peers' neighbor counts: they leave the choice to their caller.
constexpr int kCounts[] = {6, 8, 12, 17, 24, 34, 48, 68, 96, 136, 192, 272, 384};

[[noreturn]] void Fail(const absl::Status& status) {
  std::fprintf(stderr, "%s\n", status.ToString().c_str());
  std::exit(1);
}

std::vector<float> Disturbed(const std::vector<float>& positions, double sigma) {
  std::vector<curv::Vec3> moved(positions.size() / 3);
  for (size_t i = 0; i < moved.size(); ++i) {
    moved[i] = {positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]};
  }
  if (sigma > 0.0) curv::AddPositionNoise(sigma, 1, moved);
  std::vector<float> packed;
  for (const curv::Vec3& v : moved) {
    for (int axis = 0; axis < 3; ++axis) packed.push_back(static_cast<float>(v[axis]));
  }
  return packed;
}

NormalOptions Estimated() {
  NormalOptions options;
  options.source = NormalSource::kEstimate;
  return options;
}

// What the peers do: planes of so many neighbors, with normals to any side.
NormalOptions PlanesOf(int count) {
  NormalOptions options = Estimated();
  options.method = NormalMethod::kPca;
  options.neighborhood = NeighborCount{static_cast<uint32_t>(count)};
  options.sides = SidesAlongDirection{{0.0, 0.0, 1.0}};
  return options;
}

NormalResult Ours(const std::vector<float>& positions, const NormalOptions& options, WorkerPool& pool) {
  Cloud cloud(ScalarType::kFloat32, InvalidPointPolicy::kReject, NormalsInput::kAbsent);
  cloud.Expect(positions.size() / 3);
  absl::Status status =
      cloud.Append({reinterpret_cast<const char*>(positions.data()), positions.size() * sizeof(float)}, {});
  if (status.ok()) status = cloud.Finish();
  if (!status.ok()) Fail(status);
  auto made = MakeNormals(std::move(cloud), options, pool);
  if (!made.ok()) Fail(made.status());
  return *std::move(made);
}

PackedNormals Pack(const NormalField& normals) {
  PackedNormals packed;
  for (const PointNormal& point : normals.span()) packed.insert(packed.end(), point.normal.begin(), point.normal.end());
  return packed;
}

// Of the lines of the normals, in degrees; and the share of those that point to the wrong side.
struct Errors {
  double mean_angle;
  double flipped;
};

Errors ErrorsOf(const PackedNormals& normals, const std::vector<float>& truth) {
  double angles = 0.0;
  size_t flipped = 0, count = 0;
  for (size_t i = 0; i < truth.size(); i += 3) {
    double dot = 0.0;
    for (size_t axis = 0; axis < 3; ++axis) dot += double{normals[i + axis]} * truth[i + axis];
    if (!std::isfinite(dot)) continue;
    angles += std::acos(std::min(std::abs(dot), 1.0)) * 180.0 / std::numbers::pi;
    flipped += dot < 0.0 ? 1 : 0;
    ++count;
  }
  return {angles / static_cast<double>(count), static_cast<double>(flipped) / static_cast<double>(count)};
}

void MeasureAngles(const Flags& flags, Table& table, Targets& targets) {
  WorkerPool pool(2);
  const std::vector<double> levels = flags.quick
                                         ? std::vector<double>{0.0, 0.1}
                                         : std::vector<double>{0.0, 0.025, 0.05, 0.075, 0.1, 0.125, 0.15, 0.175, 0.2};
  for (const char* surface : {"goursat", "torus"}) {
    const BenchCloud cloud = SurfaceCloud(surface, flags.quick ? 5'000 : 25'000, flags.clouds);
    for (const double sigma : levels) {
      const std::vector<float> positions = Disturbed(cloud.positions, sigma);
      const NormalResult made = Ours(positions, Estimated(), pool);
      const double ours = ErrorsOf(Pack(made.normals), cloud.normals).mean_angle;
      std::vector<std::string> row = {
          surface, absl::StrCat(cloud.size()), Digits(sigma), Digits(ours),
          absl::StrCat(std::string(NormalMethodName(*made.report.method)), " ", made.report.neighbor_count)};
      double best = 1e300;
      for (const NormalPeer& peer : NormalPeers()) {
        double least = 1e300;
        int best_count = 0;
        for (const int count : kCounts) {
          const double angle = ErrorsOf(peer.estimate(positions, count), cloud.normals).mean_angle;
          if (angle < least) best_count = count;
          least = std::min(least, angle);
        }
        row.push_back(Digits(least));
        row.push_back(absl::StrCat(best_count));
        best = std::min(best, least);
      }
      row.push_back(Digits(ours / best));
      table.AddRow(row);
      targets.AtMost(absl::StrCat("angle of normals over the best peer's at its best K; ", surface, ", noise ", sigma),
                     1.0, ours / best, "x");
    }
  }
}

// What one way took in each round, and the normals of the last.
struct Costs {
  std::string who, what;
  std::vector<double> walls, cpus;
  PackedNormals normals;
};

template <typename Run>
void AddRound(const Run& run, Costs& costs) {
  const double wall = WallSeconds(), cpu = CpuSeconds();
  PackedNormals normals = run();
  costs.walls.push_back(WallSeconds() - wall);
  costs.cpus.push_back(CpuSeconds() - cpu);
  costs.normals = std::move(normals);
}

// The median over the rounds of what one took over what the other took in the same round: the machine's pace changes
// from round to round.
double MedianRatio(const std::vector<double>& over, const std::vector<double>& under) {
  std::vector<double> ratios;
  for (size_t round = 0; round < over.size(); ++round) ratios.push_back(over[round] / under[round]);
  return Median(ratios);
}

void AddCosts(const std::string& cloud, const Costs& costs, const Costs& ours, const std::vector<float>& truth,
              Table& table) {
  const Errors errors = ErrorsOf(costs.normals, truth);
  const double wall_ratio = MedianRatio(costs.walls, ours.walls), cpu_ratio = MedianRatio(costs.cpus, ours.cpus);
  table.AddRow({cloud, costs.who, costs.what, Digits(Median(costs.walls)), Digits(Median(costs.cpus)),
                Digits(wall_ratio), Digits(cpu_ratio), Digits(errors.mean_angle), Digits(100.0 * errors.flipped)});
}

// Each round runs everybody once, one after the other.
void MeasureTimes(const Flags& flags, Table& table, Targets& targets) {
  constexpr int kPeersCount = 30;  // Open3D's default
  WorkerPool pool(2);
  const size_t points = flags.quick ? 20'000 : 1'000'000;
  const BenchCloud torus = SurfaceCloud("torus", points, flags.clouds);
  for (const double sigma : {0.0, 0.02}) {
    const std::vector<float> positions = Disturbed(torus.positions, sigma);
    const std::string name = absl::StrCat("torus ", points, ", noise ", sigma);
    Costs ours{.who = "curvd", .what = "estimated, oriented", .walls = {}, .cpus = {}, .normals = {}};
    Costs planes{.who = "curvd", .what = "planes of 30, any side", .walls = {}, .cpus = {}, .normals = {}};
    std::vector<Costs> peers, oriented;
    for (const NormalPeer& peer : NormalPeers()) {
      peers.push_back({.who = peer.name, .what = planes.what, .walls = {}, .cpus = {}, .normals = {}});
      // Orientation takes Open3D minutes.
      const bool orients = peer.orient != nullptr && (flags.quick || flags.full);
      oriented.push_back(
          {.who = orients ? peer.name : "", .what = "planes of 30, oriented", .walls = {}, .cpus = {}, .normals = {}});
    }
    for (int round = 0; round < flags.RoundsOr(3); ++round) {
      AddRound([&] { return Pack(Ours(positions, Estimated(), pool).normals); }, ours);
      AddRound([&] { return Pack(Ours(positions, PlanesOf(kPeersCount), pool).normals); }, planes);
      for (size_t p = 0; p < peers.size(); ++p) {
        AddRound([&] { return NormalPeers()[p].estimate(positions, kPeersCount); }, peers[p]);
        if (oriented[p].who.empty()) continue;
        AddRound([&] { return NormalPeers()[p].orient(positions, kPeersCount); }, oriented[p]);
      }
    }
    AddCosts(name, ours, ours, torus.normals, table);
    AddCosts(name, planes, ours, torus.normals, table);
    for (size_t p = 0; p < peers.size(); ++p) {
      AddCosts(name, peers[p], ours, torus.normals, table);
      targets.AtLeast(absl::StrCat(peers[p].who, " over curvd, planes of 30 by both, any side; ", name), 5.0,
                      MedianRatio(peers[p].cpus, planes.cpus), "x CPU");
      targets.AtLeast(absl::StrCat(peers[p].who, " without sides over curvd with; ", name), 5.0,
                      MedianRatio(peers[p].cpus, ours.cpus), "x CPU");
      if (oriented[p].who.empty()) continue;
      AddCosts(name, oriented[p], ours, torus.normals, table);
      targets.AtLeast(absl::StrCat(peers[p].who, " over curvd; ", name), 5.0, MedianRatio(oriented[p].cpus, ours.cpus),
                      "x CPU");
    }
  }
}

void Main(const Flags& flags) {
  if (NormalPeers().empty()) {
    std::fprintf(stderr, "built without PCL and Open3D: install libpcl-dev and libopen3d-dev, and build again\n");
    std::exit(1);
  }
  std::vector<std::string> columns = {"surface", "points", "noise", "curvd; degrees", "by"};
  for (const NormalPeer& peer : NormalPeers()) {
    columns.push_back(absl::StrCat(peer.name, "; degrees"));
    columns.push_back("its best K");
  }
  columns.push_back("curvd / best peer");
  Table angles("normal_peers_angles", columns);
  Table times("normal_peers_times", {"cloud", "who", "what", "wall s", "CPU s", "wall / curvd", "CPU / curvd",
                                     "mean angle; degrees", "flipped; %"});
  Targets targets("normal_peers");
  MeasureTimes(flags, times, targets);
  times.Finish(flags.out);
  MeasureAngles(flags, angles, targets);
  angles.Finish(flags.out);
  targets.Finish(flags.out);
}

}  // namespace
}  // namespace curvd::bench

int main(int argc, char** argv) {
  curvd::bench::Main(curvd::bench::ParseFlags(argc, argv, "Normals of positions beside those of PCL and Open3D"));
}
