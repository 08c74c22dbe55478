// The whole core in one thread, from a cloud in memory to its curvature field, against two ways to do the same work
// with nanoflann and plain code.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "bench/core_run.h"
#include "bench/flags.h"
#include "bench/peers/peers.h"
#include "bench/table.h"

namespace curvd::bench {
namespace {

constexpr char kOurs[] = "curvd, 1 rotation";
constexpr char kOursDefault[] = "curvd, 2 rotations (default)";
constexpr char kCommon[] = "common way";
constexpr char kStrongest[] = "strongest peer";
constexpr char kTuned[] = "strongest peer, tuned estimator";

struct Case {
  const BenchCloud& cloud;
  uint32_t k;
  int rounds;
  size_t one_in;  // of the peers' queries
};

bool WasQueried(const PointCurvature& point) { return point.status != PointStatus{}; }

// Last results of each way.
struct Fields {
  std::map<std::string, std::vector<PointCurvature>> by_way;
};

double MeanError(const BenchCloud& cloud, const std::vector<PointCurvature>& field) {
  double sum = 0.0;
  size_t queried = 0;
  for (size_t i = 0; i < field.size(); ++i) {
    if (!WasQueried(field[i])) continue;
    sum += std::abs(static_cast<double>(field[i].mean) - cloud.true_mean[i]);
    ++queried;
  }
  return sum / static_cast<double>(queried);  // NaN if a point has no value
}

// Where two fields were compared, and how far apart they are.
struct Agreement {
  double difference = 0.0;  // mean difference of H over its mean magnitude
  size_t unestimated = 0;   // points that curvd gives a status and no value
  size_t opposed = 0;       // points where the normals of a sector cancel (bench/peers/plain_estimator.h)
};

Agreement Compare(const std::vector<PointCurvature>& ours, const std::vector<PointCurvature>& peer) {
  Agreement agreement;
  double difference = 0.0, magnitude = 0.0;
  for (size_t i = 0; i < ours.size(); ++i) {
    if (!WasQueried(peer[i])) continue;
    if (ours[i].status != PointStatus::kOk) {
      ++agreement.unestimated;
    } else if (peer[i].status != PointStatus::kOk) {
      ++agreement.opposed;
    } else {
      difference += std::abs(static_cast<double>(ours[i].mean) - peer[i].mean);
      magnitude += std::abs(static_cast<double>(peer[i].mean));
    }
  }
  agreement.difference = difference / magnitude;
  return agreement;
}

// All ways must have done the same work; ends the program otherwise.
void CheckAgreement(const Case& c, const Fields& fields, Table& table) {
  constexpr double kTolerance = 1e-4;  // float rounding is 1e-6; a sector's bound may fall either way at a few points
  constexpr double kMaxLeftOut = 0.03;
  for (const char* way : {kCommon, kStrongest, kTuned}) {
    const Agreement agreement = Compare(fields.by_way.at(kOurs), fields.by_way.at(way));
    table.AddRow({c.cloud.name, absl::StrCat(c.cloud.size()), absl::StrCat(c.k), way,
                  absl::StrFormat("%.1e", agreement.difference), absl::StrCat(agreement.unestimated),
                  absl::StrCat(agreement.opposed)});
    const auto left_out = static_cast<double>(agreement.unestimated + agreement.opposed);
    // Written so that NaN fails too.
    if (agreement.difference <= kTolerance && left_out <= kMaxLeftOut * static_cast<double>(c.cloud.size())) continue;
    std::fprintf(stderr, "%s K=%u: %s gives other results (%g relative; %g points left out): the comparison is void\n",
                 c.cloud.name.c_str(), c.k, way, agreement.difference, left_out);
    std::exit(1);
  }
}

void AddOurs(const Case& c, const char* way, uint32_t rotations, WorkerPool& pool, Fields& fields,
             SideBySide& comparison) {
  comparison.Add(way, [&c, &fields, &pool, way, rotations] {
    CurvatureField field;
    Figures figures = RunCore(c.cloud, OptionsFor("avg-hexagram", c.k, rotations), pool, &field);
    const std::span<const PointCurvature> points = field.points.span();
    fields.by_way[way].assign(points.begin(), points.end());
    return figures;
  });
}

template <typename Run>
void AddPeer(const Case& c, const char* way, Run run, Fields& fields, SideBySide& comparison) {
  comparison.Add(way, [&c, &fields, way, run] {
    // Pages that are mapped for this run alone, as ours.
    fields.by_way[way] = std::vector<PointCurvature>();
    auto field = PageArray<PointCurvature>::Create(c.cloud.size());
    const PeerCost cost = run(field->data());
    const std::span<const PointCurvature> points = field->span();
    fields.by_way[way].assign(points.begin(), points.end());
    return Figures{{"total", cost.build + cost.query}, {"build", cost.build}, {"query", cost.query}};
  });
}

std::map<std::string, Figures> Measure(const Case& c, WorkerPool& pool, Fields& fields) {
  const BenchCloud& cloud = c.cloud;
  const std::vector<double> positions(cloud.positions.begin(), cloud.positions.end());
  const std::vector<double> normals(cloud.normals.begin(), cloud.normals.end());
  SideBySide comparison(absl::StrCat(cloud.name, " ", cloud.size(), " K=", c.k));
  AddOurs(c, kOurs, 1, pool, fields, comparison);
  AddOurs(c, kOursDefault, 2, pool, fields, comparison);
  AddPeer(
      c, kCommon,
      [&](PointCurvature* out) {
        return RunCommonWay(positions, normals, c.k, PeerWork::kPlainEstimate, out, c.one_in);
      },
      fields, comparison);
  for (const char* way : {kStrongest, kTuned}) {
    const PeerWork work = way == kTuned ? PeerWork::kTunedEstimate : PeerWork::kPlainEstimate;
    AddPeer(
        c, way,
        [&, work](PointCurvature* out) {
          return RunStrongestPeer(cloud.positions, cloud.normals, c.k, work, out, c.one_in);
        },
        fields, comparison);
  }
  return comparison.Run(c.rounds);
}

void Report(const Case& c, std::map<std::string, Figures>& medians, const Fields& fields, Table& table,
            Targets& targets) {
  const auto points = static_cast<double>(c.cloud.size());
  const double ours = medians[kOurs]["total"], ours_default = medians[kOursDefault]["total"];
  for (const char* way : {kOurs, kOursDefault, kCommon, kStrongest, kTuned}) {
    Figures& figures = medians[way];
    const auto micros = [&](const char* name) { return Digits(1e6 * figures[name] / points); };
    table.AddRow({c.cloud.name, absl::StrCat(c.cloud.size()), absl::StrCat(c.k), way, micros("build"), micros("query"),
                  micros("total"), Digits(figures["total"] / ours), Digits(figures["total"] / ours_default),
                  c.cloud.true_mean.empty() ? "-" : Digits(MeanError(c.cloud, fields.by_way.at(way)))});
  }
  const auto target = [&](const char* peer, double wanted) {
    const double total = medians[peer]["total"];
    const std::string what = absl::StrCat(c.cloud.name, " ", c.cloud.size(), " points K=", c.k, ": times ", peer);
    targets.AtLeast(absl::StrCat(what, " (1 rotation)"), wanted, total / ours, "x");
    targets.AtLeast(absl::StrCat(what, " (default)"), wanted, total / ours_default, "x");
  };
  target(kCommon, c.k == 50 ? 12.0 : 30.0);
  target(kStrongest, c.k == 50 ? 4.5 : 20.0);
}

std::vector<BenchCloud> Clouds(const Flags& flags, size_t points) {
  std::vector<BenchCloud> clouds;
  for (const char* surface : {"torus", "goursat"}) clouds.push_back(SurfaceCloud(surface, points, flags.clouds));
  return clouds;
}

// What takes little time is measured more often: a machine's spells last longer than a short measurement.
int UsualRounds(const BenchCloud& cloud, uint32_t k) {
  constexpr size_t kWork = 375'000'000;  // points times neighbors: 15 rounds for 500,000 and 50
  return static_cast<int>(std::clamp<size_t>(kWork / (cloud.size() * k), 5, 25));
}

void RunCases(const Flags& flags, const std::vector<BenchCloud>& clouds, size_t one_in, Table& table, Table& agreement,
              Targets& targets) {
  WorkerPool pool(1);
  for (const BenchCloud& cloud : clouds) {
    for (uint32_t k : {50u, 300u}) {
      const Case c{cloud, k, flags.RoundsOr(UsualRounds(cloud, k)), one_in};
      Fields fields;
      std::map<std::string, Figures> medians = Measure(c, pool, fields);
      CheckAgreement(c, fields, agreement);
      Report(c, medians, fields, table, targets);
    }
  }
}

void Main(const Flags& flags) {
  Table table("core", {"cloud", "points", "K", "way", "build us/point", "search + estimate us/point", "total us/point",
                       "times curvd (1 rotation)", "times curvd (default)", "mean H error"});
  Table agreement("core_agreement", {"cloud", "points", "K", "way", "H differs from curvd by", "points without a value",
                                     "points with opposed normals"});
  Targets targets("core");
  std::vector<BenchCloud> clouds = Clouds(flags, flags.quick ? 50'000 : 500'000);
  if (auto armadillo = ArmadilloCloud()) clouds.push_back(*std::move(armadillo));
  RunCases(flags, clouds, 1, table, agreement, targets);
  // All of the peers' queries would take minutes a run.
  if (flags.full) RunCases(flags, Clouds(flags, 5'000'000), 20, table, agreement, targets);
  table.Finish(flags.out);
  agreement.Finish(flags.out);
  targets.Finish(flags.out);
}

}  // namespace
}  // namespace curvd::bench

int main(int argc, char** argv) {
  curvd::bench::Main(curvd::bench::ParseFlags(argc, argv, "The whole core in one thread, against nanoflann"));
}
