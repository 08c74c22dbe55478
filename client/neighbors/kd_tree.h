// Nearest neighbors among positions.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "client/surfaces/vec3.h"

namespace curv {

struct Neighbor {
  uint32_t index;
  double squared_distance;
};

// A balanced k-d tree: the middle of each range of its order is a node, short ranges are leaves. Not thread-safe.
class KdTree {
 public:
  static constexpr int kMaxCount = 32;

  // REQUIRES: positions are finite, fewer than 2^32.
  explicit KdTree(const std::vector<Vec3>& positions);

  // Calls visit(i, neighbors) once for each position i, with its `count` nearest other positions, nearest first; with
  // all others, if there are fewer. Positions come in an order in which close ones follow each other.
  // REQUIRES: count in [1, kMaxCount].
  template <typename Visitor>
  void ForEach(int count, const Visitor& visit) {
    count_ = static_cast<size_t>(count);
    for (query_ = 0; query_ < sorted_.size(); ++query_) {
      found_ = 0;
      Search(0, sorted_.size());
      visit(order_[query_], std::span<const Neighbor>(nearest_.data(), found_));
    }
  }

 private:
  void Build(const std::vector<Vec3>& positions, size_t begin, size_t end);
  void Search(size_t begin, size_t end);
  void Consider(size_t at);

  std::vector<uint32_t> order_;  // indices of positions in the tree's order
  std::vector<uint8_t> axes_;    // along which a node divides
  std::vector<Vec3> sorted_;
  // Of the search that runs.
  size_t count_ = 0;
  size_t query_ = 0;
  size_t found_ = 0;
  std::array<Neighbor, kMaxCount> nearest_{};
};

}  // namespace curv
