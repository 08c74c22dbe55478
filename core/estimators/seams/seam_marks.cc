#include "core/estimators/seams/seam_marks.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace curvd {
namespace {

constexpr size_t kGroupsTogether = 16;
// Beyond doubt by chance is at most one of so many marked points, as far as was measured.
constexpr double kChanceOf = 25.0;
constexpr double kDeviations = 4.0;

// Whether so many points are beyond doubt as chance leaves none: all, or more than its share by four standard
// deviations and one.
bool AreOfSeam(uint64_t sure, uint64_t marked) {
  if (sure == 0) return false;
  const double by_chance = static_cast<double>(marked) / kChanceOf;
  return sure == marked || static_cast<double>(sure) > 1.0 + by_chance + kDeviations * std::sqrt(by_chance);
}

}  // namespace

absl::StatusOr<SeamMarks> SeamMarks::Create(size_t group_count) {
  auto groups = PageArray<GroupMarks>::Create(group_count);
  if (!groups.ok()) return groups.status();
  SeamMarks marks;
  marks.groups_ = *std::move(groups);
  std::fill(marks.groups_.data(), marks.groups_.data() + group_count, GroupMarks{});
  return marks;
}

uint64_t SeamMarks::SurePoints() const {
  uint64_t count = 0;
  for (const GroupMarks& group : groups_.span()) count += static_cast<uint64_t>(std::popcount(group.sure));
  return count;
}

bool SeamMarks::ShowSeam() const {
  for (size_t first = 0; first < groups_.size(); first += kGroupsTogether) {
    uint64_t sure = 0, marked = 0;
    for (size_t i = first; i < std::min(first + kGroupsTogether, groups_.size()); ++i) {
      sure += static_cast<uint64_t>(std::popcount(groups_[i].sure));
      marked += static_cast<uint64_t>(std::popcount(groups_[i].marked));
    }
    if (AreOfSeam(sure, marked)) return true;
  }
  return false;
}

}  // namespace curvd
