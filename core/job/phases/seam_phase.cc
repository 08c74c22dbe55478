#include "core/job/phases/seam_phase.h"

#include <algorithm>
#include <chrono>
#include <string>

#include "absl/strings/str_cat.h"
#include "core/base/error.h"
#include "core/estimators/seams/seam_reach.h"

namespace curvd {
namespace {

// The place in the input of the first point that is surely beside a seam.
size_t FirstSure(const SeamMarks& marks, const SpatialIndex& index) {
  size_t first = index.point_count();
  for (size_t place = 0; place < index.point_count(); ++place) {
    constexpr size_t kLeaf = SpatialIndex::kLeafSize;
    if (!marks.IsSure(place)) continue;
    const int32_t rank = index.positions(place / kLeaf).id[place % kLeaf];
    first = std::min(first, index.point_set().place_of(rank));
  }
  return first;
}

class SeamPhase final : public Phase {
 public:
  explicit SeamPhase(const SeamWork& work) : work_(work), groups_per_block_(GroupsPerBlock(work.options)) {}

  std::string_view name() const override { return kSeamPhase; }

  absl::StatusOr<size_t> Begin() override {
    if (!work_.marks.ShowSeam()) return 0;
    if (work_.options.opposed_normals == OpposedNormalsPolicy::kReject) return RefusalOf(work_.marks, work_.index);
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

  const SeamWork work_;
  const size_t groups_per_block_;
  size_t block_count_ = 0;  // that the phase begins with
};

}  // namespace

std::unique_ptr<Phase> MakeSeamPhase(const SeamWork& work) { return std::make_unique<SeamPhase>(work); }

absl::Status RefusalOf(const SeamMarks& marks, const SpatialIndex& index) {
  constexpr char kOpposed[] = "opposed to those of neighbors on the same surface";
  const uint64_t seam_points = marks.SurePoints();
  const size_t first = FirstSure(marks, index);
  return MakeCoreError(ErrorKind::kOpposedNormals,
                       absl::StrCat("normals of ", seam_points, " points are ", kOpposed, ", such as around point ",
                                    first, "; make all normals point to one side"),
                       {"normals", absl::StrCat(kOpposed, " at ", seam_points, " points"),
                        "on one side of each surface (opposed_normals_policy)", absl::StrCat(first)});
}

}  // namespace curvd
