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

struct Cost {
  double wall, cpu;
  PackedNormals normals;
};

template <typename Run>
Cost CostOf(const Run& run) {
  const double wall = WallSeconds(), cpu = CpuSeconds();
  PackedNormals normals = run();
  return {WallSeconds() - wall, CpuSeconds() - cpu, std::move(normals)};
}

void AddCost(const std::string& cloud, const std::string& who, const std::string& what, const Cost& cost,
             const Cost& ours, const std::vector<float>& truth, Table& table) {
  const Errors errors = ErrorsOf(cost.normals, truth);
  table.AddRow({cloud, who, what, Digits(cost.wall), Digits(cost.cpu), Digits(cost.wall / ours.wall),
                Digits(cost.cpu / ours.cpu), Digits(errors.mean_angle), Digits(100.0 * errors.flipped)});
}

void MeasureTimes(const Flags& flags, Table& table, Targets& targets) {
  constexpr int kPeersCount = 30;  // Open3D's default
  WorkerPool pool(2);
  const size_t points = flags.quick ? 20'000 : 1'000'000;
  const BenchCloud torus = SurfaceCloud("torus", points, flags.clouds);
  for (const double sigma : {0.0, 0.02}) {
    const std::vector<float> positions = Disturbed(torus.positions, sigma);
    const std::string name = absl::StrCat("torus ", points, ", noise ", sigma);
    const Cost ours = CostOf([&] { return Pack(Ours(positions, Estimated(), pool).normals); });
    const Cost planes = CostOf([&] { return Pack(Ours(positions, PlanesOf(kPeersCount), pool).normals); });
    AddCost(name, "curvd", "estimated, oriented", ours, ours, torus.normals, table);
    AddCost(name, "curvd", "planes of 30, any side", planes, ours, torus.normals, table);
    for (const NormalPeer& peer : NormalPeers()) {
      const Cost estimated = CostOf([&] { return peer.estimate(positions, kPeersCount); });
      AddCost(name, peer.name, "planes of 30, any side", estimated, ours, torus.normals, table);
      targets.AtLeast(absl::StrCat(peer.name, " over curvd, planes of 30 by both, any side; ", name), 5.0,
                      estimated.cpu / planes.cpu, "x CPU");
      // Orientation takes Open3D minutes.
      if (peer.orient == nullptr || !(flags.quick || flags.full)) {
        targets.AtLeast(absl::StrCat(peer.name, " without sides over curvd with; ", name), 1.0,
                        estimated.cpu / ours.cpu, "x CPU");
        continue;
      }
      const Cost oriented = CostOf([&] { return peer.orient(positions, kPeersCount); });
      AddCost(name, peer.name, "planes of 30, oriented", oriented, ours, torus.normals, table);
      targets.AtLeast(absl::StrCat(peer.name, " over curvd; ", name), 5.0, oriented.cpu / ours.cpu, "x CPU");
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
