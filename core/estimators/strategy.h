// What an estimator is to the rest of the core: a row in a table, and what it runs.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/estimators/curvature_field.h"
#include "core/estimators/options.h"
#include "core/estimators/point_choice.h"
#include "core/estimators/seams/seam_marks.h"
#include "core/index/spatial_index.h"

namespace curvd {

struct ScaleReport;

// What one thread works with while it runs the phases of a strategy. Each strategy derives its own. Not thread-safe.
struct WorkerScratch {
  virtual ~WorkerScratch() = default;
  // Bytes that it holds, itself included.
  virtual size_t bytes() const = 0;

  // Once true, nobody wants the result any more; null: somebody does. Looked at after each point, and within searches
  // that may be long.
  const std::atomic<bool>* stopped = nullptr;
  bool IsStopped() const { return stopped != nullptr && stopped->load(std::memory_order_relaxed); }

  // A run of a group (GroupPhase::run) ends after the point with which it has taken more than `most_work` steps, so
  // that no group of a cloud that is made to cost much keeps others waiting: it then leaves the rest of the group to
  // another run. `first_point` says with which of the group's points a run begins, in tree order, and `rest` with which
  // the next one is to; 0: none is left. Whoever runs a group sets first_point before and reads `rest` afterwards.
  uint64_t most_work = kMostRunWork;
  size_t first_point = 0;
  size_t rest = 0;
  // Steps of all runs so far (SearchScratch::work). 0 where nobody counts.
  virtual uint64_t work() const { return 0; }
  // So many take some ten milliseconds; a group of ordinary points takes 12,000 at 50 neighbors, a million or so at
  // 10,000.
  static constexpr uint64_t kMostRunWork = uint64_t{2} << 20;
  // As most_work: no run ends early.
  static constexpr uint64_t kNoLimit = std::numeric_limits<uint64_t>::max();

  // Makes the next run on this scratch a part of the run on `outer`: it ends when that is stopped, begins with the same
  // point, and takes so many steps at most.
  void RunWithin(const WorkerScratch& outer, uint64_t most) {
    stopped = outer.stopped;
    most_work = most;
    first_point = outer.first_point;
    rest = 0;
  }

  // How many points it has written, by PointStatus.
  std::array<uint64_t, kPointStatusEnd> status_counts{};

  // Where points that may be beside a seam are marked, for all workers: an array with marks for each scale of the run;
  // null: nowhere.
  SeamMarks* seams = nullptr;
};

// One pass over the groups of an index. Phases run one after the other; the groups of a phase in any order, on any
// thread.
struct GroupPhase {
  // What progress and errors call it; outlives the run.
  std::string_view name;
  // Called once, before any group; allocates what the phase needs. May be empty.
  // Errors: ErrorKind::kOutOfMemory, the system gave no memory. May throw std::bad_alloc.
  std::function<absl::Status()> begin;
  // Runs a group, or its rest (WorkerScratch::first_point).
  // Thread-safe for distinct groups and distinct scratch: of MakeScratch, of this run or one whose scratch is of its
  // type. Errors: ErrorKind::kNeighborhoodTooLarge; kCancelled once the scratch is stopped. The run is then of no
  // further use. May throw std::bad_alloc.
  std::function<absl::Status(size_t group, WorkerScratch& scratch)> run;
  // Called once after `begin`: whether the phase has anything to do. If not, no group is run. Empty: it has.
  std::function<bool()> is_needed = nullptr;

  // Begins the phase, and returns whether its groups are to be run. Errors: those of `begin`.
  absl::StatusOr<bool> Begin() const {
    if (begin) {
      if (absl::Status status = begin(); !status.ok()) return status;
    }
    return !is_needed || is_needed();
  }
};

// One estimate, or another walk over the groups of an index: what all workers share.
class StrategyRun {
 public:
  virtual ~StrategyRun() = default;
  virtual std::unique_ptr<WorkerScratch> MakeScratch() const = 0;
  // The phases, in order, which refer to this run. The last one of a strategy, but "seams", writes every result.
  virtual std::vector<GroupPhase> Phases() = 0;
  // Bytes that its phases have allocated for all workers together.
  virtual size_t bytes() const { return 0; }
  // What was chosen, complete once the last phase has run; null where nothing is.
  virtual const ScaleReport* scale_report() const { return nullptr; }
  // Says where the last phase writes, at each point's slot, how its estimate was chosen. Runs that choose nothing write
  // nothing. REQUIRES: called before the first phase, if EstimatorOptions::returns_choice; `choices` outlives the run.
  virtual void WriteChoicesTo(PointChoice* /*choices*/) {}
};

// An option that a strategy reads, besides `neighborhood` and `average_normal_weight`, which all take; by its name in
// core/estimators/option_specs.h.
using OptionName = std::string_view;

struct Strategy {
  // What clients, files and command lines call it: "avg-hexagram".
  std::string_view name;
  // What curvature.v1.Estimator calls it, without the prefix ESTIMATOR_; empty: `name` in capitals, with _ for -.
  std::string_view wire_name;
  // What it makes of a neighborhood, in one line.
  std::string_view summary;
  std::span<const OptionName> options;
  // Whether a cloud without normals can not be estimated by it.
  bool needs_normals;
  // Bytes a point beyond cloud, index and results, which its phases allocate.
  size_t bytes_per_point;
  // Bytes that the scratch of one worker holds at most for a cloud of so many points.
  // REQUIRES: options.Validate() is OK.
  size_t (*scratch_bytes)(const EstimatorOptions& options, size_t point_count);
  // Bytes that its phases allocate for all workers together at most, beyond those by the point. Null: none.
  // REQUIRES: as above.
  size_t (*shared_bytes)(const EstimatorOptions& options, size_t point_count) = nullptr;
  // How far from a point its estimate looks at most, in units of the radius that it reports; by a number of neighbors
  // that is at least `least_bounded_count`. By radius, and with fewer neighbors, no factor bounds it where that is not
  // 0.
  double reach_factor = 1.0;
  size_t least_bounded_count = 0;
  // Prepares the estimate of every query point of `index`, which outlives the run, like `results`:
  // results[slot] is written for each, at its slot (PointSet::slot_of). REQUIRES: options.Validate() is OK; by count,
  // the index holds as many points as are asked for.
  std::unique_ptr<StrategyRun> (*start)(const EstimatorOptions& options, const SpatialIndex& index,
                                        PointCurvature* results);
  // The same at several scales with one search: results[scale] gets what the options of that scale alone
  // (EstimatorOptions::AtScale) give, to the byte. Null: the strategy takes one scale. REQUIRES: as above;
  // results.size() is options.scale_count().
  std::unique_ptr<StrategyRun> (*start_scales)(const EstimatorOptions& options, const SpatialIndex& index,
                                               std::span<PointCurvature* const> results) = nullptr;
};

}  // namespace curvd
