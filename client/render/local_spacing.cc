#include "client/render/local_spacing.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>

namespace curv {
namespace {

constexpr size_t kLeafSize = 12;

// A balanced k-d tree: the middle of each range is its root, unless the range is a leaf.
class SpacingTree {
 public:
  explicit SpacingTree(const std::vector<Vec3>& positions) : order_(positions.size()), axes_(positions.size()) {
    std::iota(order_.begin(), order_.end(), 0u);
    Build(positions, 0, positions.size());
    for (const uint32_t i : order_) sorted_.push_back(positions[i]);
  }

  // Calls visit(i, spacing) for each position.
  template <typename Visitor>
  void ForEach(int rank, const Visitor& visit) {
    rank_ = static_cast<size_t>(rank);
    for (size_t at = 0; at < sorted_.size(); ++at) {
      found_ = 0;
      query_ = at;
      Search(0, sorted_.size());
      visit(order_[at], found_ == 0 ? 0.0 : std::sqrt(nearest_[found_ - 1]));
    }
  }

 private:
  void Build(const std::vector<Vec3>& positions, size_t begin, size_t end) {
    if (end - begin <= kLeafSize) return;
    Vec3 low = positions[order_[begin]], high = low;
    for (size_t at = begin; at < end; ++at) {
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], positions[order_[at]][axis]);
        high[axis] = std::max(high[axis], positions[order_[at]][axis]);
      }
    }
    const Vec3 extent = high - low;
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    const size_t middle = begin + (end - begin) / 2;
    std::nth_element(order_.begin() + static_cast<ptrdiff_t>(begin), order_.begin() + static_cast<ptrdiff_t>(middle),
                     order_.begin() + static_cast<ptrdiff_t>(end),
                     [&](uint32_t a, uint32_t b) { return positions[a][axis] < positions[b][axis]; });
    axes_[middle] = static_cast<uint8_t>(axis);
    Build(positions, begin, middle);
    Build(positions, middle + 1, end);
  }

  void Search(size_t begin, size_t end) {
    if (end - begin <= kLeafSize) {
      for (size_t at = begin; at < end; ++at) Consider(at);
      return;
    }
    const size_t middle = begin + (end - begin) / 2;
    const int axis = axes_[middle];
    const double offset = sorted_[query_][axis] - sorted_[middle][axis];
    const bool left_first = offset < 0.0;
    left_first ? Search(begin, middle) : Search(middle + 1, end);
    if (found_ < rank_ || offset * offset < nearest_[found_ - 1]) {
      Consider(middle);
      left_first ? Search(middle + 1, end) : Search(begin, middle);
    }
  }

  // Inserts into the short sorted list of squared distances.
  void Consider(size_t at) {
    if (at == query_) return;
    const Vec3 offset = sorted_[at] - sorted_[query_];
    const double squared = Dot(offset, offset);
    if (found_ == rank_ && squared >= nearest_[found_ - 1]) return;
    if (found_ < rank_) ++found_;
    size_t slot = found_ - 1;
    for (; slot > 0 && nearest_[slot - 1] > squared; --slot) nearest_[slot] = nearest_[slot - 1];
    nearest_[slot] = squared;
  }

  std::vector<uint32_t> order_;
  std::vector<uint8_t> axes_;
  std::vector<Vec3> sorted_;
  size_t rank_ = 0;
  size_t query_ = 0;
  size_t found_ = 0;
  std::array<double, 16> nearest_{};
};

}  // namespace

std::vector<double> LocalSpacing(const std::vector<Vec3>& positions, int rank) {
  std::vector<double> spacing(positions.size());
  SpacingTree(positions).ForEach(rank, [&](uint32_t i, double distance) { spacing[i] = distance; });
  return spacing;
}

}  // namespace curv
