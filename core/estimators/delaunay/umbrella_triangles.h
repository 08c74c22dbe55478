// The umbrella triangles near a group of query points, with their measures: made once, summed by every query.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>

#include "core/base/scratch_array.h"
#include "core/estimators/delaunay/umbrella.h"
#include "core/index/spatial_index.h"
#include "core/search/leaf_list.h"

namespace curvd {

// Corrected measures of a triangle, turned so that its area is not negative, times a third of the umbrellas that it
// occurs in. The symmetric tensor is that of docs/numerics.md for all of space; the mean measure is half its trace.
struct alignas(64) TriangleMeasures {
  // Of a triangle, floats with the last bit of a double set: their sums do not depend on the order (Odd in
  // core/estimators/fits/double_sums-inl.h).
  double values[8];

  float xx() const { return static_cast<float>(values[0]); }
  float yy() const { return static_cast<float>(values[1]); }
  float zz() const { return static_cast<float>(values[2]); }
  float xy() const { return static_cast<float>(values[3]); }
  float yz() const { return static_cast<float>(values[4]); }
  float zx() const { return static_cast<float>(values[5]); }
  float area() const { return static_cast<float>(values[6]); }
  float gaussian() const { return static_cast<float>(values[7]); }
};

// A point as a corner.
struct alignas(32) TriangleCorner {
  float position[4];  // and the bits of the point's rank
  float normal[4];    // and 0
};

// All distinct triangles whose corners lie in the leaves of a list. Points go by their place: position of the leaf in
// the list * SpatialIndex::kLeafSize + place in the leaf.
//
// Gather makes the triangles; the kernel that calls it then sets corners() of all places and measures() of all
// triangles. From then on they are read only, until Gather makes others. Not thread-safe.
//
// For a list of n leaves, Gather takes at most 2 * kLeafSize * Umbrella::kMaxTriangles * n lookups of a leaf, and each
// of them at most kMostProbes + log2(n) + 1 steps, whichever leaves are listed.
class UmbrellaTriangles {
 public:
  struct alignas(16) Triangle {
    uint32_t place[3];
    uint32_t occurrences;
  };
  // Triangles that follow the last, for who reads several at a time: they occur in no umbrella.
  static constexpr size_t kPad = SpatialIndex::kLeafSize;

  // Makes the triangles of a list, unless they are there already: returns whether it did. All weights are then those of
  // no neighbor. REQUIRES: `umbrellas`, by place in the tree order, have their occurrences counted; the list is in tree
  // order, and lives until the next Gather.
  bool Gather(const SpatialIndex& index, const Umbrella* umbrellas, const LeafList& leaves);

  size_t leaf_count() const { return leaf_count_; }
  size_t size() const { return size_; }
  // Corners that the last Gather which made triangles looked for.
  size_t lookups() const { return lookups_; }
  // Slots of the table that are looked at for a leaf, before the list is searched for it.
  static constexpr uint32_t kMostProbes = 8;
  // The triangles whose umbrella's point lies in leaf i of the list: [first(i), first(i + 1)).
  uint32_t first(size_t i) const { return first_[i]; }
  const Triangle& triangle(size_t t) const { return triangles_[t]; }
  // For the kernel that measures, which puts their corners in an order of its own. Aligned for any vector, with kPad.
  Triangle* mutable_triangles() { return triangles_.data(); }

  // Of each triangle, by its number below size().
  TriangleMeasures* measures() { return measures_.data(); }
  const TriangleMeasures* measures() const { return measures_.data(); }
  // By place.
  TriangleCorner* corners() { return corners_.data(); }

  // How much a point counts as a corner in the sums of a query, by place. Whoever sets the weights of a query's
  // neighbors puts kNoNeighbor back before the next query.
  static constexpr float kNoNeighbor = -std::numeric_limits<float>::infinity();
  float* weights() { return weights_.data(); }
  const float* weights() const { return weights_.data(); }

  // Bytes held, and held at most for lists of so many leaves, however many triangles meet there.
  size_t bytes() const;
  static size_t MostBytes(size_t leaves);

 private:
  // Where each listed leaf is in the list, by open addressing: in one of kMostProbes slots in a row, the first of which
  // its number tells. Leaves that find all of theirs taken have none.
  void SetPositions(const LeafList& leaves);
  // The position of a leaf in the list; kNowhere if it is not listed.
  uint32_t PositionOf(uint32_t leaf) const;
  // The same by bisection.
  uint32_t BisectPosition(uint32_t leaf) const;
  // The place of the point that has `tree_place` in the tree order; kNowhere if its leaf is not listed.
  uint32_t PlaceOf(int32_t tree_place) const;
  void Add(const Umbrella& umbrella, uint32_t place);

  static constexpr uint32_t kNowhere = ~uint32_t{0};
  struct Position {
    uint32_t leaf;
    uint32_t position;
  };

  const LeafList* source_ = nullptr;
  uint64_t generation_ = 0;
  size_t leaf_count_ = 0;
  size_t size_ = 0;
  size_t lookups_ = 0;
  uint32_t position_mask_ = 0;
  bool has_homeless_ = false;  // whether a listed leaf has no slot
  ScratchArray<Position> positions_;
  ScratchArray<uint32_t> first_;
  ScratchArray<Triangle> triangles_;
  ScratchArray<TriangleMeasures> measures_;
  ScratchArray<TriangleCorner> corners_;
  ScratchArray<float> weights_;
};

}  // namespace curvd
