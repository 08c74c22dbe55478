#include "client/tiles/run_tiles.h"

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "client/tiles/tile_claim.h"

namespace curv {
namespace {

// How long to wait before looking again whether another run has ended a tile.
constexpr std::chrono::milliseconds kLookAgain{200};

class Run {
 public:
  Run(const PointStore& store, const RunRequest& request, const TileEstimator& estimator, const std::stop_token& stop,
      const std::function<void(const RunProgress& progress)>& progress)
      : store_(store),
        plan_(store.plan()),
        halo_factor_(request.halo_factor),
        estimator_(estimator),
        stop_(stop),
        progress_callback_(progress) {
    const size_t first = request.tile.value_or(0), end = request.tile ? first + 1 : plan_.tiles.size();
    for (size_t tile = first; tile < end; ++tile) {
      if (IsDone(tile)) continue;
      todo_.push_back(tile);
      ++progress_.tiles;
      progress_.points += plan_.tile(tile).count;
    }
  }

  absl::StatusOr<RunOutcome> Do(int jobs) {
    {
      std::vector<std::jthread> threads;
      const size_t count = std::min<size_t>(static_cast<size_t>(jobs), todo_.size());
      for (size_t i = 0; i < count; ++i) threads.emplace_back([this] { Work(); });
    }
    const std::lock_guard lock(mutex_);
    if (!error_.ok()) return error_;
    if (stop_.stop_requested()) return absl::CancelledError("interrupted");
    return outcome_;
  }

 private:
  enum class Tried { kDone, kHeldByOther };

  bool IsDone(size_t tile) const { return ReadTileResult(plan_, tile).ok(); }

  void Work() {
    std::unique_lock lock(mutex_);
    while (!todo_.empty() && error_.ok() && !stop_.stop_requested()) {
      const size_t tile = todo_.front();
      todo_.pop_front();
      lock.unlock();
      const absl::StatusOr<Tried> tried = Try(tile);
      lock.lock();
      if (!tried.ok() && error_.ok()) error_ = tried.status();
      if (!tried.ok()) break;
      if (*tried == Tried::kDone) {
        ++progress_.tiles_done;
        progress_.points_done += plan_.tile(tile).count;
        if (progress_callback_) progress_callback_(progress_);
        since_done_ = 0;
        continue;
      }
      todo_.push_back(tile);
      // Once all that are left are at hand elsewhere.
      if (++since_done_ >= todo_.size()) pause_.wait_for(lock, stop_, kLookAgain, [] { return false; });
    }
  }

  absl::StatusOr<Tried> Try(size_t tile) {
    const std::optional<TileClaim> claim = TileClaim::Try(plan_, tile);
    if (!claim.has_value()) return Tried::kHeldByOther;
    if (IsDone(tile)) return Tried::kDone;
    const absl::StatusOr<TileResult> result = EstimateTile(store_, tile, halo_factor_, estimator_);
    if (!result.ok()) return result.status();
    const std::lock_guard lock(mutex_);
    ++outcome_.tiles;
    outcome_.points += result->points;
    outcome_.halo_points += result->halo_points;
    outcome_.uncertain_points += result->uncertain_points;
    outcome_.repair_points += result->repair_points;
    outcome_.coarse_points += result->coarse_points;
    outcome_.opposed_tiles += result->has_opposed_normals ? 1 : 0;
    outcome_.off_surface_tiles += result->has_normals_off_surface ? 1 : 0;
    return Tried::kDone;
  }

  const PointStore& store_;
  const TilePlan& plan_;
  const double halo_factor_;
  const TileEstimator& estimator_;
  const std::stop_token& stop_;
  const std::function<void(const RunProgress& progress)>& progress_callback_;
  std::mutex mutex_;  // guards what follows
  std::condition_variable_any pause_;
  std::deque<size_t> todo_;
  size_t since_done_ = 0;  // tiles in a row that others had at hand
  RunProgress progress_;
  RunOutcome outcome_;
  absl::Status error_;
};

}  // namespace

absl::StatusOr<RunOutcome> RunTiles(const TilePlan& plan, const RunRequest& request, const TileEstimator& estimator,
                                    const std::stop_token& stop,
                                    const std::function<void(const RunProgress& progress)>& progress) {
  if (request.tile.has_value() && *request.tile >= plan.tiles.size()) {
    return absl::NotFoundError(
        absl::StrCat("there is no tile ", *request.tile, ": the plan has tiles 0 to ", plan.tiles.size() - 1));
  }
  const absl::StatusOr<PointStore> store = PointStore::Open(plan);
  if (!store.ok()) return store.status();
  return Run(*store, request, estimator, stop, progress).Do(request.jobs);
}

}  // namespace curv
