#include "core/leaf_list.h"

#include <algorithm>
#include <limits>

namespace curvd {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

float SquaredDistance(const Box& a, const Box& b) {
  float squared[3];
  for (int axis = 0; axis < 3; ++axis) {
    const float gap = std::max({a.lo[axis] - b.hi[axis], b.lo[axis] - a.hi[axis], 0.0f});
    squared[axis] = gap * gap;
  }
  return (squared[0] + squared[1]) + squared[2];
}

struct Pending {
  uint32_t node;
  uint32_t first_leaf;
  uint32_t leaves;
};
constexpr size_t kMaxDepth = 64;  // the tree is balanced over fewer than 2^31 leaves

}  // namespace

bool LeafList::Gather(const SpatialIndex& index, const Box& box, float squared_reach, size_t max_leaves) {
  size_ = 0;
  if (index.leaf_count() == 0) return true;
  Pending stack[kMaxDepth];
  size_t depth = 0;
  stack[depth++] = {0, 0, static_cast<uint32_t>(index.leaf_count())};
  while (depth > 0) {
    const Pending top = stack[--depth];
    const TreeNode& node = index.node(top.node);
    if (SquaredDistance(node.box, box) > squared_reach) continue;
    if (top.leaves == 1) {
      if (size_ == max_leaves) return false;
      Add(top.first_leaf, node.box);
      continue;
    }
    const auto left = static_cast<uint32_t>(SpatialIndex::LeftLeaves(top.leaves));
    const auto right_child = static_cast<uint32_t>(SpatialIndex::RightChild(top.node, top.leaves));
    stack[depth++] = {right_child, top.first_leaf + left, top.leaves - left};
    stack[depth++] = {top.node + 1, top.first_leaf, left};
  }
  Pad();
  return true;
}

void LeafList::Add(uint32_t leaf, const Box& box) {
  if (size_ + kPad >= leaves_.capacity()) {
    leaves_.Reserve(2 * size_ + 256);
    for (auto& bound : bounds_) bound.Reserve(2 * size_ + 256);
  }
  leaves_[size_] = leaf;
  for (int axis = 0; axis < 3; ++axis) {
    bounds_[axis][size_] = box.lo[axis];
    bounds_[3 + axis][size_] = box.hi[axis];
  }
  ++size_;
}

void LeafList::Pad() {
  for (size_t i = size_; i < padded_size(); ++i) {
    for (auto& bound : bounds_) bound[i] = kInfinity;
  }
}

}  // namespace curvd
