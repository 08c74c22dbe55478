#include "core/scale/edges/edge_marks.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace curvd {
namespace {

// Roughness is a standard deviation over 26 times two degrees of freedom: chance takes it to 1.5 times what is usual
// at one point in a million.
constexpr double kMostNoise = 1.5;
// What an edge of 20 degrees makes of exact normals. Surfaces without edges stay below, unless they bend by a radian
// within the neighborhood.
constexpr double kLeastRoughness = 0.06;

// A point may be rough, or have rough ones around it, above this share of what makes it so: 1.3 times what is usual,
// which chance makes of one point in 300.
constexpr double kMayBeShare = 0.87;

// An edge that crosses a group has a row of points to either side. Fewer than this are there by chance, and would take
// every neighborhood away that reaches them.
constexpr size_t kLeastInGroup = 4;

}  // namespace

EdgeMarks::EdgeMarks(const SpatialIndex& index)
    : index_(index),
      trends_(index.leaf_count() * SpatialIndex::kLeafSize),
      marks_(index.leaf_count() * SpatialIndex::kLeafSize) {}

double EdgeMarks::NoiseAt(size_t place, const EdgeNoise& noise) const {
  return std::sqrt(SquaredNoiseAt(place, noise));
}

double EdgeMarks::SquaredNoiseAt(size_t place, const EdgeNoise& noise) const {
  const double of_positions = noise.of_positions * trends_[place].slope;
  return noise.of_normals * noise.of_normals + of_positions * of_positions;
}

bool EdgeMarks::IsRougher(size_t place, double share, const EdgeNoise& noise) const {
  const double roughness = trends_[place].roughness;
  const double most_smooth = kMostNoise * kMostNoise * SquaredNoiseAt(place, noise) + kLeastRoughness * kLeastRoughness;
  return roughness * roughness > share * share * most_smooth;
}

bool EdgeMarks::IsRough(size_t place, const EdgeNoise& noise) const { return IsRougher(place, 1.0, noise); }

bool EdgeMarks::MayBeRough(size_t place, const EdgeNoise& noise) const { return IsRougher(place, kMayBeShare, noise); }

void EdgeMarks::MarkGroup(size_t group, size_t rough_count, uint64_t has_faces) {
  rough_count_ += rough_count;
  const auto edges = static_cast<size_t>(std::popcount(has_faces));
  if (edges < kLeastInGroup) return;
  edge_count_ += edges;
  for (; has_faces != 0; has_faces &= has_faces - 1) {
    marks_[group * SpatialIndex::kGroupPoints + static_cast<size_t>(std::countr_zero(has_faces))] = 1;
  }
}

void EdgeMarks::Finish() {
  below_.assign(2 * index_.leaf_count(), 0);
  if (index_.leaf_count() > 0) MarkNode(0, 0, index_.leaf_count());
}

bool EdgeMarks::MarkNode(size_t node, size_t first_leaf, size_t leaves) {
  bool has_edge = false;
  if (leaves == 1) {
    const auto first = marks_.begin() + static_cast<std::ptrdiff_t>(first_leaf * SpatialIndex::kLeafSize);
    has_edge = std::any_of(first, first + SpatialIndex::kLeafSize, [](uint8_t mark) { return mark != 0; });
  } else {
    const size_t left = SpatialIndex::LeftLeaves(leaves);
    has_edge = MarkNode(node + 1, first_leaf, left);
    has_edge |= MarkNode(SpatialIndex::RightChild(node, leaves), first_leaf + left, leaves - left);
  }
  below_[node] = has_edge ? 1 : 0;
  return has_edge;
}

float EdgeMarks::SquaredDistance(const float* position, float most) const {
  float nearest = most;
  if (HasEdges()) Descend(0, 0, index_.leaf_count(), position, nearest);
  return nearest;
}

void EdgeMarks::Descend(size_t node, size_t first_leaf, size_t leaves, const float* position, float& nearest) const {
  if (below_[node] == 0 || !(curvd::SquaredDistance(position, index_.node(node).box) < nearest)) return;
  if (leaves > 1) {
    const size_t left = SpatialIndex::LeftLeaves(leaves), right_node = SpatialIndex::RightChild(node, leaves);
    const bool right_first = curvd::SquaredDistance(position, index_.node(right_node).box) <
                             curvd::SquaredDistance(position, index_.node(node + 1).box);
    if (right_first) Descend(right_node, first_leaf + left, leaves - left, position, nearest);
    Descend(node + 1, first_leaf, left, position, nearest);
    if (!right_first) Descend(right_node, first_leaf + left, leaves - left, position, nearest);
    return;
  }
  const SpatialIndex::LeafPositions& points = index_.positions(first_leaf);
  for (int i = 0; i < index_.LeafPoints(first_leaf); ++i) {
    if (marks_[first_leaf * SpatialIndex::kLeafSize + static_cast<size_t>(i)] == 0) continue;
    const float x = points.x[i] - position[0], y = points.y[i] - position[1], z = points.z[i] - position[2];
    nearest = std::min(nearest, x * x + y * y + z * z);
  }
}

}  // namespace curvd
