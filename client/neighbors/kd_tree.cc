#include "client/neighbors/kd_tree.h"

#include <algorithm>
#include <numeric>

namespace curv {
namespace {

constexpr size_t kLeafSize = 12;

int LongestAxis(const std::vector<Vec3>& positions, std::span<const uint32_t> indices) {
  Vec3 low = positions[indices[0]], high = low;
  for (const uint32_t i : indices) {
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], positions[i][axis]);
      high[axis] = std::max(high[axis], positions[i][axis]);
    }
  }
  const Vec3 extent = high - low;
  return extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
}

}  // namespace

KdTree::KdTree(const std::vector<Vec3>& positions) : order_(positions.size()), axes_(positions.size()) {
  std::iota(order_.begin(), order_.end(), 0u);
  Build(positions, 0, positions.size());
  sorted_.reserve(positions.size());
  for (const uint32_t i : order_) sorted_.push_back(positions[i]);
}

void KdTree::Build(const std::vector<Vec3>& positions, size_t begin, size_t end) {
  if (end - begin <= kLeafSize) return;
  const int axis = LongestAxis(positions, std::span(order_).subspan(begin, end - begin));
  const size_t middle = begin + (end - begin) / 2;
  const auto at = [this](size_t i) { return order_.begin() + static_cast<ptrdiff_t>(i); };
  std::nth_element(at(begin), at(middle), at(end),
                   [&](uint32_t a, uint32_t b) { return positions[a][axis] < positions[b][axis]; });
  axes_[middle] = static_cast<uint8_t>(axis);
  Build(positions, begin, middle);
  Build(positions, middle + 1, end);
}

void KdTree::Search(size_t begin, size_t end) {
  if (end - begin <= kLeafSize) {
    for (size_t at = begin; at < end; ++at) Consider(at);
    return;
  }
  const size_t middle = begin + (end - begin) / 2;
  const int axis = axes_[middle];
  const double offset = sorted_[query_][axis] - sorted_[middle][axis];
  const bool left_first = offset < 0.0;
  left_first ? Search(begin, middle) : Search(middle + 1, end);
  if (found_ == count_ && offset * offset >= nearest_[found_ - 1].squared_distance) return;
  Consider(middle);
  left_first ? Search(middle + 1, end) : Search(begin, middle);
}

// Inserts into the short sorted list.
void KdTree::Consider(size_t at) {
  if (at == query_) return;
  const Vec3 offset = sorted_[at] - sorted_[query_];
  const double squared = Dot(offset, offset);
  if (found_ == count_ && squared >= nearest_[found_ - 1].squared_distance) return;
  if (found_ < count_) ++found_;
  size_t slot = found_ - 1;
  for (; slot > 0 && nearest_[slot - 1].squared_distance > squared; --slot) nearest_[slot] = nearest_[slot - 1];
  nearest_[slot] = {order_[at], squared};
}

}  // namespace curv
