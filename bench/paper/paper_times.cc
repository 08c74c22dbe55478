// Time a point of every estimator over K, and of its peer on the same cloud in the same run: what Figure 5 shows.
//
// "After the search" is measured, for ours, as the whole estimate less the search alone (bench/core_search.h: the same
// search by the same code, neighbors collected into arrays); the peers get their neighbor lists beforehand. One thread;
// CPU time; the median of the rounds, all ways in random turns.
#include <cstdio>
#include <fstream>
#include <functional>
#include <optional>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "bench/core_run.h"
#include "bench/core_search.h"
#include "bench/paper/errors.h"
#include "bench/paper/figure_flags.h"
#include "bench/paper/methods.h"
#include "bench/paper/samples.h"
#include "bench/peers/morton_order.h"
#include "bench/peers/plain_peers.h"
#include "bench/stopwatch.h"

namespace curvd::bench {
namespace {

// How much is measured.
struct Extent {
  size_t points;
  size_t peer_points;  // the first of the cloud; CGAL takes 10 s for all
  int rounds;
  std::vector<uint32_t> neighbor_counts;
};

Extent ExtentOf(const FigureFlags& flags) {
  if (flags.tiny) return {2'000, 200, 1, {20, 50}};
  if (flags.quick) return {50'000, 2'000, 3, {15, 50, 200}};
  return {50'000, 10'000, 7, {10, 15, 25, 50, 100, 200, 400}};
}

using RunPeer = std::function<void(const PeerCloud&, const PeerNeighbors&, PointCurvature*)>;

struct Peer {
  std::string name;
  RunPeer run;
  bool for_whole_cloud = false;  // works on all points before the first result
};

// What `method` is measured against; nothing for several rotations, which no peer has.
std::optional<Peer> PeerOf(const Method& method) {
  const EstimatorOptions& options = method.options;
  const std::string_view estimator = options.estimator;
  if (estimator == "avg-hexagram") {
    if (options.rotation_count > 1) return std::nullopt;
    return Peer{"plain double", RunPlainAvgHexagram};
  }
  if (estimator == "hexagram") return Peer{"plain double", RunPlainHexagram};
  if (estimator == "uniform") {
    return Peer{"plain double", [count = options.triangle_count](const auto& cloud, const auto& near, auto* out) {
                  RunPlainUniform(cloud, near, count, out);
                }};
  }
  if (estimator == "independent") {
    return Peer{"plain double", [count = options.triangle_count](const auto& cloud, const auto& near, auto* out) {
                  RunPlainIndependent(cloud, near, count, out);
                }};
  }
  if (estimator == "delaunay") {
    return Peer{"plain double",
                [](const auto& cloud, const auto& near, auto* out) { RunPlainUmbrellas(cloud, near, 31, out); }, true};
  }
  if (estimator == "jet") {
    return Peer{"CGAL", [degree = options.jet_degree](const auto& cloud, const auto& near, auto* out) {
                  RunCgalJet(cloud, near, degree, out);
                }};
  }
  if (estimator == "aso") return Peer{"plain double", RunPlainShapeOperator};
  return std::nullopt;
}

// The cloud in the order that suits the peers; curvd sorts points itself.
struct TimedCloud {
  BenchCloud ours;
  std::vector<double> positions, normals;
  std::vector<curv::SurfaceGeometry> truth;

  PeerCloud peers() const { return {positions, normals}; }
};

TimedCloud MakeCloud(size_t points) {
  const Samples samples = SampleEvenly("goursat", points, 1);
  std::vector<float> packed;
  for (const curv::Vec3& p : samples.positions) {
    for (int axis = 0; axis < 3; ++axis) packed.push_back(static_cast<float>(p[axis]));
  }
  TimedCloud cloud;
  cloud.ours.name = "goursat";
  for (uint32_t i : MortonOrder(packed)) {
    for (int axis = 0; axis < 3; ++axis) {
      cloud.positions.push_back(samples.positions[i][axis]);
      cloud.normals.push_back(samples.normals[i][axis]);
    }
    cloud.truth.push_back(samples.truth[i]);
  }
  cloud.ours.positions.assign(cloud.positions.begin(), cloud.positions.end());
  cloud.ours.normals.assign(cloud.normals.begin(), cloud.normals.end());
  return cloud;
}

// All ways for one K.
class Comparison {
 public:
  Comparison(const TimedCloud& cloud, const Extent& extent, uint32_t k)
      : cloud_(cloud),
        extent_(extent),
        k_(k),
        index_(BuildIndex(ToCloud(cloud.ours))),
        side_by_side_(absl::StrCat("goursat ", extent.points, " K=", k)) {}

  // Rows of the CSV file.
  std::string Run() {
    AddSearches();
    for (const Method& method : PaperMethods()) {
      AddOurs(method);
      if (const auto peer = PeerOf(method)) AddPeer(method, *peer);
    }
    std::map<std::string, Figures> medians = side_by_side_.Run(extent_.rounds);
    std::string rows;
    for (const Method& method : PaperMethods()) rows += Row(method, medians);
    return rows;
  }

 private:
  static std::string Ours(const Method& method) { return "curvd: " + method.name; }
  static std::string Theirs(const Method& method) { return "peer: " + method.name; }
  // Hexagram searches in its own way, all others alike.
  static std::string SearchOf(const Method& method) {
    return method.options.estimator == "hexagram" ? "search of hexagram" : "search";
  }

  void AddSearch(const Method& method) {
    side_by_side_.Add(SearchOf(method), [this, estimator = method.options.estimator] {
      std::vector<float> radii(extent_.points);
      const double start = CpuSeconds();
      SearchByGroups(index_, estimator, k_, radii.data());
      return Figures{{"total", CpuSeconds() - start}};
    });
  }

  void AddSearches() {
    AddSearch(MethodNamed("avg-hexagram R=1"));
    AddSearch(MethodNamed("hexagram"));
    side_by_side_.Add("peer search", [this] {
      const double start = CpuSeconds();
      neighbors_ = FindPeerNeighbors(cloud_.peers(), k_, extent_.points);
      return Figures{{"total", CpuSeconds() - start}};
    });
    neighbors_ = FindPeerNeighbors(cloud_.peers(), k_, extent_.points);
    few_neighbors_ = FindPeerNeighbors(cloud_.peers(), k_, extent_.peer_points);
  }

  void AddOurs(const Method& method) {
    side_by_side_.Add(Ours(method), [this, method] {
      CurvatureField field;
      const Figures figures = RunCore(cloud_.ours, method.WithNeighbors(k_), pool_, &field);
      errors_[Ours(method)] = MeanError(field.points.span());
      return figures;
    });
  }

  void AddPeer(const Method& method, const Peer& peer) {
    side_by_side_.Add(Theirs(method), [this, method, peer] {
      const PeerNeighbors& neighbors = peer.for_whole_cloud ? neighbors_ : few_neighbors_;
      std::vector<PointCurvature> field(neighbors.size());
      const double start = CpuSeconds();
      peer.run(cloud_.peers(), neighbors, field.data());
      const double seconds = CpuSeconds() - start;
      errors_[Theirs(method)] = MeanError(field);
      return Figures{{"total", seconds * static_cast<double>(extent_.points) / static_cast<double>(field.size())}};
    });
  }

  // Of H, over the points that every peer estimates.
  double MeanError(std::span<const PointCurvature> field) const {
    const std::span truth(cloud_.truth);
    return MeasureErrors(field.first(extent_.peer_points), truth.first(extent_.peer_points)).mean.mean;
  }

  std::string Row(const Method& method, std::map<std::string, Figures>& medians) {
    const auto micros = [&](const std::string& way, const char* figure) {
      return 1e6 * medians.at(way).at(figure) / static_cast<double>(extent_.points);
    };
    const double search = micros(SearchOf(method), "total");
    const double after = micros(Ours(method), "query") - search;
    std::string row = absl::StrFormat("%d,%d,%s,%.4f,%.4f,%.4f,%.4f,%.4e", extent_.points, k_, method.name,
                                      micros(Ours(method), "build"), search, after, micros(Ours(method), "total"),
                                      errors_[Ours(method)]);
    if (const auto peer = PeerOf(method)) {
      const double their = micros(Theirs(method), "total"), their_search = micros("peer search", "total");
      absl::StrAppendFormat(&row, ",%s,%.4f,%.4f,%.4e\n", peer->name, their, their + their_search,
                            errors_[Theirs(method)]);
    } else {
      row += ",,,,\n";
    }
    return row;
  }

  const TimedCloud& cloud_;
  const Extent extent_;
  const uint32_t k_;
  WorkerPool pool_{1};
  SpatialIndex index_;
  PeerNeighbors neighbors_, few_neighbors_;
  std::map<std::string, double> errors_;  // mean error of H by way
  SideBySide side_by_side_;
};

int Main(const FigureFlags& flags) {
  const Extent extent = ExtentOf(flags);
  const TimedCloud cloud = MakeCloud(extent.points);
  std::ofstream file(flags.out);
  file << "points,K,method,index_us,search_us,after_search_us,total_us,H_mae,peer,peer_after_search_us,peer_total_us,"
          "peer_H_mae\n";
  for (uint32_t k : extent.neighbor_counts) file << Comparison(cloud, extent, k).Run();
  file.close();
  if (file) return 0;
  std::fprintf(stderr, "cannot write %s\n", flags.out.c_str());
  return 1;
}

}  // namespace
}  // namespace curvd::bench

int main(int argc, char** argv) {
  return curvd::bench::Main(curvd::bench::ParseFigureFlags(argc, argv, "Time a point of every estimator and its peer",
                                                           "Fewer neighbor counts and rounds"));
}
