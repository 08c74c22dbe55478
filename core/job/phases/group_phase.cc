#include "core/job/phases/group_phase.h"

#include <algorithm>
#include <utility>
#include <variant>

namespace curvd {
namespace {

class GroupBlocks final : public Phase {
 public:
  GroupBlocks(GroupPhase groups, const SpatialIndex& index, size_t groups_per_block, ScratchSet& scratch,
              std::atomic<size_t>* points_done, BlockClock now)
      : groups_(std::move(groups)),
        index_(index),
        groups_per_block_(groups_per_block),
        scratch_(scratch),
        points_done_(points_done),
        now_(now) {}

  std::string_view name() const override { return groups_.name; }

  absl::StatusOr<size_t> Begin() override {
    const absl::StatusOr<bool> is_needed = groups_.Begin();
    if (!is_needed.ok()) return is_needed.status();
    if (!*is_needed) return 0;
    block_count_ = (index_.group_count() + groups_per_block_ - 1) / groups_per_block_;
    return block_count_;
  }

  absl::Status RunBlock(const BlockContext& context) override {
    WorkerScratch& scratch = scratch_.of(context.worker);
    scratch.stopped = &context.stopped;
    const Place begin = BeginOf(context.block);
    const size_t last = std::min((begin.group / groups_per_block_ + 1) * groups_per_block_, index_.group_count());
    const std::chrono::steady_clock::time_point started = now_();
    const uint64_t work_before = scratch.work();
    Place next = begin;
    while (next.group < last) {
      if (context.stopped.load(std::memory_order_relaxed)) return absl::OkStatus();
      scratch.first_point = next.point;
      scratch.rest = 0;
      if (absl::Status status = groups_.run(next.group, scratch); !status.ok()) return status;
      next = scratch.rest > 0 ? Place{next.group, scratch.rest} : Place{next.group + 1, 0};
      if (next.group == last) break;
      if (next.point > 0 || scratch.work() - work_before > WorkerScratch::kMostRunWork ||
          now_() - started > kLongBlock) {
        context.add_block(BlockFrom(next));
        break;
      }
    }
    if (points_done_ != nullptr) *points_done_ += QueriesIn(begin.group, next.group);
    return absl::OkStatus();
  }

 private:
  // A point of a group, of those that the phase takes on.
  struct Place {
    size_t group;
    size_t point;
  };

  // A block past the first ones is the rest of one of those, from the place that its number tells.
  Place BeginOf(size_t block) const {
    if (block < block_count_) return {block * groups_per_block_, 0};
    const size_t number = block - block_count_;
    return {number / SpatialIndex::kGroupPoints, number % SpatialIndex::kGroupPoints};
  }
  size_t BlockFrom(const Place& place) const {
    return block_count_ + place.group * SpatialIndex::kGroupPoints + place.point;
  }

  size_t PointsBefore(size_t group) const { return std::min(group * SpatialIndex::kGroupPoints, index_.point_count()); }

  // Points of groups [first, last) that get results: those of a group in parts count with its last part.
  size_t QueriesIn(size_t first, size_t last) const {
    const size_t begin = PointsBefore(first), end = PointsBefore(last);
    const PointSet& set = index_.point_set();
    if (!set.has_roles()) return end - begin;
    size_t count = 0;
    for (size_t i = begin; i < end; ++i) {
      const int32_t rank = index_.positions(i / SpatialIndex::kLeafSize).id[i % SpatialIndex::kLeafSize];
      count += set.is_query(rank) ? 1 : 0;
    }
    return count;
  }

  const GroupPhase groups_;
  const SpatialIndex& index_;
  const size_t groups_per_block_;
  size_t block_count_ = 0;  // that the phase begins with
  ScratchSet& scratch_;
  std::atomic<size_t>* const points_done_;
  const BlockClock now_;
};

}  // namespace

size_t GroupsPerBlock(const EstimatorOptions& options) {
  constexpr size_t kMost = 16;
  constexpr size_t kNeighborsPerBlock = kMost * 64;  // neighbors of one point, times groups
  constexpr size_t kForRadius = 4;                   // nobody knows how many neighbors there will be
  const auto* neighbors = std::get_if<NeighborCount>(&options.neighborhood);
  if (neighbors == nullptr) return kForRadius;
  return std::clamp<size_t>(kNeighborsPerBlock / std::max<size_t>(neighbors->count, 1), 1, kMost);
}

WorkerScratch& ScratchSet::of(int worker) {
  std::unique_ptr<WorkerScratch>& scratch = scratch_[worker];
  if (scratch == nullptr) {
    scratch = run_.MakeScratch();
    scratch->seams = seams_;
  }
  return *scratch;
}

std::array<uint64_t, kPointStatusEnd> ScratchSet::status_counts() const {
  std::array<uint64_t, kPointStatusEnd> counts{};
  for (const auto& scratch : scratch_) {
    if (scratch == nullptr) continue;
    for (int status = 0; status < kPointStatusEnd; ++status) counts[status] += scratch->status_counts[status];
  }
  return counts;
}

std::unique_ptr<Phase> MakeGroupPhase(GroupPhase groups, const SpatialIndex& index, size_t groups_per_block,
                                      ScratchSet& scratch, std::atomic<size_t>* points_done, BlockClock now) {
  return std::make_unique<GroupBlocks>(std::move(groups), index, groups_per_block, scratch, points_done, now);
}

}  // namespace curvd
