// Normals of unoriented points: fits to the positions of each point's neighbors.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/halves.h"
#include "core/base/page_array.h"
#include "core/estimators/fits/fit_scratch.h"
#include "core/estimators/neighborhood_plan.h"
#include "core/estimators/strategy.h"
#include "core/index/spatial_index.h"
#include "core/normals/normal_options.h"

namespace curvd {

// How points are fitted where positions are much noisier than elsewhere.
struct NoisyPart {
  NormalMethod method = NormalMethod::kJet2;
  NeighborCount neighborhood{};
  bool shares = false;         // as in NormalFit
  bool crosses_lines = false;  // as in NormalFit
  // Which groups these are: those whose points, one of each leaf, lie so far from quadrics through so many neighbors in
  // the median, squared, in the index's unit.
  uint32_t probe_count = 0;
  double least_variance = 0.0;
  double quiet_variance = 0.0;  // the same of the other groups, in the median
  // By their own fits, neighborhoods of these reach into noise if they lie this many times as far away, squared, as by
  // the quadrics, or as quiet_variance says where that is more.
  static constexpr double kMixedRatio = 2.5;
};

// How points are fitted beside edges of the surface: by the method of the other points.
struct EdgePart {
  NeighborCount neighborhood{};  // fewer than elsewhere
  // Of the positions' noise, in the index's unit.
  double variance = 0.0;

  // A neighborhood reaches across an edge if its fit leaves more of the heights than so many times what noise leaves.
  // The fit has so many neighbors more than coefficients.
  static double MostOfNoise(double freedom);
};

// One way to make normals, of those that NormalOptions may ask for.
struct NormalFit {
  // Fewer neighbors are not shared (see `shares`): the points of a leaf would be too far from its mean beside their
  // radius.
  static constexpr uint32_t kLeastShared = size_t{16} * SpatialIndex::kLeafSize;

  NormalMethod method = NormalMethod::kJet2;
  std::variant<NeighborCount, NeighborRadius> neighborhood{};
  uint32_t max_neighbor_count = 10'000;
  // Whether neighborhoods hold both sheets of a thin part. At its rim, no fit to both tells where the rim looks:
  // normals there turn from one sheet's to the other's.
  bool two_sheets = false;
  // Whether the points of a leaf of the index share one polynomial, fitted to the neighbors of their mean and read
  // where each of them lies. Points that are far from the mean, and those of leaves without a fit, have their own.
  // REQUIRES: by count; the degree is 2 or more; not two_sheets.
  bool shares = false;
  // Whether points lie on lines that are farther from each other than the points of one. Where neighborhoods cross too
  // few, noise decides a polynomial of the degree; such points get one of a lower degree. Elsewhere, as in narrow
  // strips, one that noise decides in part is better.
  bool crosses_lines = false;
  // If set, points of groups that are noisier than others are fitted by this. Those of other groups whose neighborhoods
  // reach into noise get half of the neighbors, and again, until they do not. REQUIRES: by count; not two_sheets.
  std::optional<NoisyPart> noisy_part{};
  // If set, points whose neighborhoods reach across an edge get half of the neighbors, and again, until these lie on
  // one side, or until they are no more than those of the edge part, which fits the points that are left. REQUIRES: by
  // count, of which the edge part has at most half; neither shares, nor two_sheets, nor noisy_part.
  std::optional<EdgePart> edge_part{};
  // Of which half of the cloud points are fitted, and are the neighbors that they are fitted to, which still lie among
  // as many of both halves. DEFAULT: of both. REQUIRES: not two_sheets.
  std::optional<Half> half{};

  // The options of an estimate that has the same neighborhoods, and needs the same scratch.
  EstimatorOptions ToEstimatorOptions() const;
  // Those of an estimate that takes about as long for a point as the fit.
  EstimatorOptions OptionsForOnePoint() const;
};

// The plane through so many neighbors, the point itself included, by their principal axes.
NormalFit PlaneFit(size_t neighbor_count);

struct NoisyPlan;
struct EdgePlan;

// A fit to the neighborhoods of one index. REQUIRES: by count, the index holds as many points.
struct NormalPlan {
  NormalPlan(const NormalFit& fit, const SpatialIndex& index);

  NeighborhoodPlan neighborhood;
  int degree;  // of the polynomial; 0: no polynomial
  bool two_sheets;
  bool shares;
  bool crosses_lines;
  std::optional<Half> half;
  std::shared_ptr<const NoisyPlan> noisy;  // null: groups are fitted alike
  std::shared_ptr<const EdgePlan> edges;   // null: the points of a group are fitted alike
};

struct NoisyPlan {
  NormalPlan probe;  // tells which groups are fitted by the other one
  NormalPlan fit;
  std::vector<NormalPlan> quiet;  // of ever fewer neighbors, each half of those before; the first is that of the fit
  double least_variance, quiet_variance;  // as NoisyPart has both
};

struct EdgePlan {
  std::vector<NormalPlan> rungs;  // of ever fewer neighbors; by the last one, points are fitted whatever it leaves
  std::vector<double> most;       // by rung: the most that a fit to one side leaves of the heights, squared
  bool last_has_halves;           // whether the last rung has enough neighbors for normals of halves
};

// The fit of one point of a group, as long as what it was solved from is known.
struct FittedPoint {
  size_t point;   // of the group, or of its sample
  size_t system;  // which of NormalScratch::system, with its radius in NormalScratch::frames
  double u, v;    // where in that system's frame the polynomial is read, in units of rho
  std::array<double, 3> normal;
  double mean_square;  // as NormalScratch has it
};

// The neighbors of as many points as vectors have lanes, as offsets: the j-th of the point in lane l at j times the
// number of lanes, plus l.
struct alignas(64) LaneNeighbors {
  static constexpr size_t kMostNeighbors = 64;
  static constexpr size_t kRoom = kMostNeighbors * SpatialIndex::kLeafSize / 2;
  float x[kRoom], y[kRoom], z[kRoom];
  double in_frame[3][kRoom];  // the same in the frames of the points, in units of rho
};

// What points that share polynomials get.
struct SharedFits {
  GroupPoints members;
  size_t leaf_of[SpatialIndex::kGroupPoints];  // of each member: which of the group's leaves with members
  GroupDoubleVectors normal;
  GroupDoubles mean_square, variance_ratio;
};

// What one thread fits normals with: a group of points at a time.
struct NormalScratch : JetScratch {
  // Of each point of the group whose status is kOk:
  GroupDoubleVectors normal{};              // of unit length
  GroupDoubles mean_square{};               // distance of the neighbors from the fit, squared, in units of rho
  GroupDoubles variance_ratio{};            // as PointNormal has it
  GroupDoubles breadth{};                   // middle variance of the neighbors' positions over the widest: 0 a line
  bool is_rim[SpatialIndex::kGroupPoints];  // whether `normal` is that of a rim (NormalFit::two_sheets)
  GroupDoubles mean_square_height{};        // of the neighbors along the axis of least spread, in units of rho
  // If not empty, called once the neighbors of point i of a sample and its frame are known.
  std::function<void(size_t i)> inspect{};
  // If not empty, called for each point whose status is kOk once its polynomial is solved.
  std::function<void(const FittedPoint& fitted)> take{};
  LaneNeighbors lanes{};
  SharedFits shared{};            // of the group of the moment, where points share fits
  bool is_noisy = false;          // whether the group was fitted as the noisy part is
  uint64_t chosen = kAllOfGroup;  // which points of a group are fitted, a bit for each place

  static constexpr uint64_t kAllOfGroup = ~uint64_t{0};

  size_t bytes() const override { return JetScratch::bytes() - sizeof(JetScratch) + sizeof(*this); }
  static size_t MostBytes(const NormalFit& fit, size_t point_count) {
    return JetScratch::MostBytes(fit.ToEstimatorOptions(), point_count) - sizeof(JetScratch) + sizeof(NormalScratch);
  }
};

// Which points of a group are fitted: all, or the first one of each leaf.
enum class GroupSample : uint8_t { kAll, kOneOfEachLeaf };

// Fits the points of a group, halo included; what comes out is in `scratch`, with the status of each point. Writes
// nothing else, and reads no normals of other groups. Thread-safe for distinct scratch.
// Errors: ErrorKind::kNeighborhoodTooLarge; kCancelled once the scratch is stopped. May throw std::bad_alloc.
// REQUIRES: index.has_normals(); they may have any values.
absl::Status FitGroup(const SpatialIndex& index, const NormalPlan& plan, size_t group, GroupSample sample,
                      NormalScratch& scratch);

// The same by the plan's own neighborhoods alone, of the points that scratch.chosen tells.
absl::Status FitChosen(const SpatialIndex& index, const NormalPlan& plan, size_t group, GroupSample sample,
                       NormalScratch& scratch);

// The plan by which FitGroup fits that group: of `plan` itself, or of one of its parts. Errors: as FitGroup has them.
absl::StatusOr<const NormalPlan*> PlanOfGroup(const SpatialIndex& index, const NormalPlan& plan, size_t group,
                                              NormalScratch& scratch);

// The scratch of each worker that fits the few points of samples. Thread-safe for distinct workers.
class SampleScratch {
 public:
  explicit SampleScratch(int thread_count) : of_worker_(static_cast<size_t>(thread_count)) {}

  // Made when it is asked for first. No run ends between the points of a sample. May throw std::bad_alloc.
  NormalScratch& Of(int worker, const std::atomic<bool>& stopped);

 private:
  std::vector<std::unique_ptr<NormalScratch>> of_worker_;
};

// Quality of the normals of an index, by place in the tree order: leaf * SpatialIndex::kLeafSize + lane.
struct NormalQuality {
  PageArray<PointStatus> status;
  // Empty unless they are wanted.
  PageArray<float> residual;
  PageArray<float> variance_ratio;

  // Errors: ErrorKind::kOutOfMemory.
  absl::Status Create(size_t places, bool wants_all);
  size_t bytes() const { return status.bytes() + residual.bytes() + variance_ratio.bytes(); }
};

// At most `most` groups at even distances in the tree order: a sample of the cloud.
std::vector<size_t> SampleGroups(const SpatialIndex& index, size_t most);

// The distance between neighboring values that coordinates take, in the index's unit, as a sample of the points shows
// it: of positions that were rounded to a lattice, such as centimeters, or single precision far away from the origin.
// That of the finest axis, so that heights over a grid have none. 0 where they take any value.
double LatticeStep(const SpatialIndex& index);

// A run of one phase, "normals", which fits every point, halo included, and writes its normal to the index, NaN where
// there is none, and its quality. The counts of its scratch are of the points that get a result. Normals have any sign.
// REQUIRES: index.has_normals(); `quality` has a place for each point of each leaf; both outlive the run.
std::unique_ptr<StrategyRun> StartNormalFit(const NormalFit& fit, SpatialIndex& index, NormalQuality& quality);

}  // namespace curvd
