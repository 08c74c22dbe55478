#include "client/neighbors/nearest_neighbors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <nanoflann.hpp>

#include "client/neighbors/parallel.h"

namespace curv {
namespace {

// Returns a power of two that brings coordinates into a range in which neither squares of distances nor the sums that
// nanoflann divides boxes by overflow or vanish. It is 1, or rounds nothing, for every cloud that is not out of reach.
double SafeScale(const std::vector<Vec3>& positions) {
  constexpr int kSafeExponent = 400, kLargestExponent = 1022;
  double largest = 0.0;
  for (const Vec3& p : positions) largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  const int exponent = largest > 0.0 ? std::ilogb(largest) : 0;
  return std::abs(exponent) <= kSafeExponent ? 1.0 : std::ldexp(1.0, std::min(-exponent, kLargestExponent));
}

// Lets nanoflann read the positions where they are.
struct PositionsView {
  const std::vector<Vec3>& positions;
  double scale = SafeScale(positions);

  Vec3 Scaled(size_t i) const { return scale * positions[i]; }
  size_t kdtree_get_point_count() const { return positions.size(); }
  double kdtree_get_pt(size_t i, size_t axis) const { return scale * positions[i][static_cast<int>(axis)]; }
  template <typename Box>
  bool kdtree_get_bbox(Box&) const {
    return false;  // nanoflann computes it
  }
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, PositionsView>, PositionsView,
                                                 /*DIM=*/3, uint32_t>;

// Collects the nearest positions in order of distance and index. Its members have the names that nanoflann calls.
class NearestSet {
 public:
  NearestSet(uint32_t query, size_t count) : query_(query), count_(count) {}

  size_t size() const { return found_; }
  bool full() const { return found_ == count_; }

  // nanoflann looks only at what is nearer than this. It adds up its bounds for whole nodes in another order than
  // distances are added up, and it leaves out what is equally distant: a few roundings more let nothing be missed.
  double worstDist() const {
    constexpr double kRoundings = 1.0 + 64.0 * std::numeric_limits<double>::epsilon();
    if (!full()) return std::numeric_limits<double>::infinity();
    return std::max(kRoundings * nearest_[found_ - 1].squared_distance, std::numeric_limits<double>::min());
  }

  // Returns false once nothing nearer can come.
  bool addPoint(double squared_distance, uint32_t index) {
    if (index == query_) return true;
    const Neighbor neighbor{index, squared_distance};
    if (full() && !IsNearer(neighbor, nearest_[found_ - 1])) return true;
    if (!full()) ++found_;
    size_t slot = found_ - 1;
    for (; slot > 0 && IsNearer(neighbor, nearest_[slot - 1]); --slot) nearest_[slot] = nearest_[slot - 1];
    nearest_[slot] = neighbor;
    return !full() || nearest_[found_ - 1].squared_distance > 0.0;
  }

  // Takes the scale out of the distances and returns the neighbors.
  std::span<const Neighbor> Finish(double scale) {
    if (scale != 1.0) {
      for (size_t i = 0; i < found_; ++i) nearest_[i].squared_distance = nearest_[i].squared_distance / scale / scale;
    }
    return {nearest_.data(), found_};
  }

 private:
  static bool IsNearer(const Neighbor& a, const Neighbor& b) {
    return a.squared_distance != b.squared_distance ? a.squared_distance < b.squared_distance : a.index < b.index;
  }

  const uint32_t query_;
  const size_t count_;
  size_t found_ = 0;
  std::array<Neighbor, kMaxNeighbors> nearest_;
};

}  // namespace

void ForEachNeighborhood(const std::vector<Vec3>& positions, int count, int threads, NeighborVisitor visit) {
  if (positions.empty()) return;
  constexpr size_t kLeafSize = 12;
  const PositionsView view{positions};
  const Tree tree(/*dimensionality=*/3, view, nanoflann::KDTreeSingleIndexAdaptorParams(kLeafSize));
  // In the tree's order, in which positions that are close to each other search the same nodes.
  ParallelFor(tree.vAcc.size(), threads, [&](size_t begin, size_t end) {
    for (size_t at = begin; at < end; ++at) {
      const uint32_t query = tree.vAcc[at];
      NearestSet nearest(query, static_cast<size_t>(count));
      const Vec3 place = view.Scaled(query);
      tree.findNeighbors(nearest, &place.x, nanoflann::SearchParams());
      visit(query, nearest.Finish(view.scale));
    }
  });
}

}  // namespace curv
