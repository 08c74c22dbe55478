#include "core/normals/winding_certificate.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace curvd {
namespace {

// A node is a dipole to points that are farther away than this many times its reach, squared.
constexpr double kFarSquared = 6.0;
// Nodes that are looked into for one point; ordinary clouds of 10 million points need a few thousand.
constexpr size_t kMostVisited = 50'000;
// Neighborhoods of so many points have the area that SideTree gives to their middle one.
constexpr double kPointsPerArea = 0.5 * (kLinksPerPoint + 1);

double Dipole(const double* offset, const double* moment, double softening) {
  const double squared = offset[0] * offset[0] + offset[1] * offset[1] + offset[2] * offset[2];
  const double soft = squared + softening;
  if (!(squared > 0.0)) return 0.0;
  return (offset[0] * moment[0] + offset[1] * moment[1] + offset[2] * moment[2]) / (soft * std::sqrt(soft));
}

}  // namespace

WindingCertificate::Place WindingCertificate::Left(const Place& parent) {
  return {parent.node + 1, parent.index_node + 1, parent.first_leaf, SpatialIndex::LeftLeaves(parent.leaves)};
}

WindingCertificate::Place WindingCertificate::Right(const Place& parent) {
  const size_t left = SpatialIndex::LeftLeaves(parent.leaves);
  return {parent.node + 2 * LeftGroups(parent.leaves), SpatialIndex::RightChild(parent.index_node, parent.leaves),
          parent.first_leaf + left, parent.leaves - left};
}

absl::Status WindingCertificate::Start() {
  const size_t groups = index_.group_count();
  auto nodes = PageArray<Node>::Create(groups == 0 ? 0 : 2 * groups - 1);
  if (!nodes.ok()) return nodes.status();
  nodes_ = *std::move(nodes);
  samples_.resize(std::min(kMostSamples, index_.point_count()));
  return absl::OkStatus();
}

size_t WindingCertificate::NodeOfGroup(size_t group) const {
  Place place{0, 0, 0, index_.leaf_count()};
  while (!place.is_group()) {
    const Place right = Right(place);
    place = group * SpatialIndex::kGroupLeaves < right.first_leaf ? Left(place) : right;
  }
  return place.node;
}

void WindingCertificate::SumChunk(size_t chunk) {
  const size_t first = chunk * SideTree::kChunkGroups;
  const size_t last = std::min(first + SideTree::kChunkGroups, index_.group_count());
  for (size_t group = first; group < last; ++group) {
    double area = 0.0, center[3] = {}, moment[3] = {};
    const size_t begin = group * SpatialIndex::kGroupPoints;
    const size_t end = std::min(begin + SpatialIndex::kGroupPoints, index_.point_count());
    for (size_t place = begin; place < end; ++place) {
      const double own = tree_.area(place);
      if (own == 0.0) continue;
      const size_t leaf = place / SpatialIndex::kLeafSize, lane = place % SpatialIndex::kLeafSize;
      const SpatialIndex::LeafPositions& p = index_.positions(leaf);
      const SpatialIndex::LeafNormals& n = index_.normals(leaf);
      area += own;
      const double position[3] = {p.x[lane], p.y[lane], p.z[lane]}, normal[3] = {n.x[lane], n.y[lane], n.z[lane]};
      for (int axis = 0; axis < 3; ++axis) {
        center[axis] += own * position[axis];
        moment[axis] += own * normal[axis];
      }
    }
    Node& node = nodes_[NodeOfGroup(group)];
    node = Node{};
    node.area = static_cast<float>(area);
    for (size_t axis = 0; axis < 3; ++axis) {
      node.moment[axis] = static_cast<float>(moment[axis]);
      if (area > 0.0) node.center[axis] = static_cast<float>(center[axis] / area);
    }
  }
}

// Sets the reach of a node whose center is set.
void WindingCertificate::Measure(const Place& place, Node& node) const {
  const Box& box = index_.node(place.index_node).box;
  double squared = 0.0;
  for (size_t axis = 0; axis < 3; ++axis) {
    const double farther = std::max(static_cast<double>(box.hi[axis]) - node.center[axis],
                                    static_cast<double>(node.center[axis]) - box.lo[axis]);
    squared += farther * farther;
  }
  node.reach = static_cast<float>(std::sqrt(squared));
}

WindingCertificate::Node WindingCertificate::SumBelow(const Place& place) {
  Node& node = nodes_[place.node];
  if (!place.is_group()) {
    const Node left = SumBelow(Left(place)), right = SumBelow(Right(place));
    node.area = left.area + right.area;
    for (size_t axis = 0; axis < 3; ++axis) {
      node.moment[axis] = left.moment[axis] + right.moment[axis];
      node.center[axis] =
          node.area > 0.0f ? (left.area * left.center[axis] + right.area * right.center[axis]) / node.area : 0.0f;
    }
  }
  Measure(place, node);
  return node;
}

void WindingCertificate::SumNodes() {
  if (nodes_.size() > 0) SumBelow({0, 0, 0, index_.leaf_count()});
}

double WindingCertificate::OfGroup(size_t first_leaf, size_t leaves, const float* query, double softening) const {
  double sum = 0.0;
  for (size_t leaf = first_leaf; leaf < first_leaf + leaves; ++leaf) {
    const SpatialIndex::LeafPositions& p = index_.positions(leaf);
    const SpatialIndex::LeafNormals& n = index_.normals(leaf);
    for (int lane = 0; lane < index_.LeafPoints(leaf); ++lane) {
      const double area = tree_.area(leaf * SpatialIndex::kLeafSize + static_cast<size_t>(lane));
      if (area == 0.0) continue;
      const double offset[3] = {static_cast<double>(p.x[lane]) - query[0], static_cast<double>(p.y[lane]) - query[1],
                                static_cast<double>(p.z[lane]) - query[2]};
      const double moment[3] = {area * n.x[lane], area * n.y[lane], area * n.z[lane]};
      sum += Dipole(offset, moment, softening);
    }
  }
  return sum;
}

// Areas are taken without their common factor here, which value() does not depend on.
double WindingCertificate::WindingNumber(size_t place) const {
  const SpatialIndex::LeafPositions& p = index_.positions(place / SpatialIndex::kLeafSize);
  const size_t lane = place % SpatialIndex::kLeafSize;
  const float query[3] = {p.x[lane], p.y[lane], p.z[lane]};
  // As far as the points are apart, the surface between them is not known: neighbors count less.
  const double softening = tree_.area(place) * std::numbers::pi / kPointsPerArea;
  constexpr size_t kMostOpen = 64;  // the tree is balanced over fewer than 2^31 leaves
  Place open[kMostOpen];
  size_t count = 0;
  open[count++] = {0, 0, 0, index_.leaf_count()};
  double sum = 0.0;
  for (size_t visited = 0; count > 0; ++visited) {
    const Place at = open[--count];
    const Node& node = nodes_[at.node];
    if (node.area == 0.0f) continue;
    const double offset[3] = {static_cast<double>(node.center[0]) - query[0],
                              static_cast<double>(node.center[1]) - query[1],
                              static_cast<double>(node.center[2]) - query[2]};
    const double squared = offset[0] * offset[0] + offset[1] * offset[1] + offset[2] * offset[2];
    if (squared > kFarSquared * node.reach * node.reach || visited > kMostVisited) {
      const double moment[3] = {node.moment[0], node.moment[1], node.moment[2]};
      sum += Dipole(offset, moment, softening);
    } else if (at.is_group()) {
      sum += OfGroup(at.first_leaf, at.leaves, query, softening);
    } else {
      open[count++] = Right(at);
      open[count++] = Left(at);
    }
  }
  return sum;
}

void WindingCertificate::Sample(size_t block, const std::atomic<bool>& stopped) {
  const size_t first = block * kBlockSamples, last = std::min(first + kBlockSamples, samples_.size());
  for (size_t i = first; i < last && !stopped.load(std::memory_order_relaxed); ++i) {
    const size_t place = (2 * i + 1) * index_.point_count() / (2 * samples_.size());
    samples_[i] = tree_.area(place) > 0.0f ? WindingNumber(place) : 0.0;
  }
}

double WindingCertificate::value() const {
  double sum = 0.0, squares = 0.0;
  size_t count = 0;
  for (const double sample : samples_) {
    if (sample == 0.0) continue;  // of a point without an area
    sum += sample;
    squares += sample * sample;
    ++count;
  }
  if (!(sum > 0.0)) return 2.0;
  return 1.0 - sum * sum / (static_cast<double>(count) * squares);
}

}  // namespace curvd
