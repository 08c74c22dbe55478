#include "core/job/seam_phase.h"

#include <algorithm>
#include <chrono>

#include "absl/strings/str_format.h"
#include "core/base/error.h"
#include "core/estimators/seams/seam_reach.h"

namespace curvd {
namespace {

class SeamPhase final : public Phase {
 public:
  explicit SeamPhase(const SeamWork& work) : work_(work), groups_per_block_(GroupsPerBlock(work.options)) {}

  std::string_view name() const override { return kSeamPhase; }

  absl::StatusOr<size_t> Begin() override {
    if (!work_.marks.ShowSeam()) return 0;
    if (work_.options.opposed_normals == OpposedNormalsPolicy::kReject) return Refusal(work_.marks.SurePoints());
    block_count_ = (work_.index.group_count() + groups_per_block_ - 1) / groups_per_block_;
    return block_count_;
  }

  absl::Status RunBlock(const BlockContext& context) override {
    // A block past the first ones is the rest of one of those, from the group that its number tells.
    const bool is_rest = context.block >= block_count_;
    size_t group = is_rest ? context.block - block_count_ : context.block * groups_per_block_;
    const size_t last = std::min((group / groups_per_block_ + 1) * groups_per_block_, work_.index.group_count());
    RefusedCounts refused{};
    const Clock::time_point started = Clock::now();
    while (group < last && !context.stopped.load(std::memory_order_relaxed)) {
      RefuseAtSeams(work_.options, work_.index, work_.marks, group, work_.results, refused);
      if (++group < last && Clock::now() - started > kLongBlock) {
        context.add_block(block_count_ + group);
        break;
      }
    }
    for (int status = 0; status < kPointStatusEnd; ++status) work_.refused[status] += refused[status];
    return absl::OkStatus();
  }

 private:
  using Clock = std::chrono::steady_clock;
  // A block that has taken so long leaves its other groups to another turn.
  static constexpr std::chrono::milliseconds kLongBlock{5};

  absl::Status Refusal(uint64_t seam_points) const {
    return MakeCoreError(
        ErrorKind::kOpposedNormals,
        absl::StrFormat(
            "normals of %u points are opposed to those of neighbors on the same surface, such as around point "
            "%d; make all normals point to one side",
            seam_points, FirstSure()));
  }

  int32_t FirstSure() const {
    int32_t first = SpatialIndex::kPaddingId;
    for (size_t place = 0; place < work_.index.point_count(); ++place) {
      constexpr size_t kLeaf = SpatialIndex::kLeafSize;
      if (work_.marks.IsSure(place)) first = std::min(first, work_.index.positions(place / kLeaf).id[place % kLeaf]);
    }
    return first;
  }

  const SeamWork work_;
  const size_t groups_per_block_;
  size_t block_count_ = 0;  // that the phase begins with
};

}  // namespace

std::unique_ptr<Phase> MakeSeamPhase(const SeamWork& work) { return std::make_unique<SeamPhase>(work); }

}  // namespace curvd
