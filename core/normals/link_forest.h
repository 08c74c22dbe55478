// Of the links of a part of a cloud, those that a tree of cheapest links over the whole cloud may hold.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/scratch_array.h"
#include "core/normals/normal_links.h"

namespace curvd {

// Sets of things with numbers below size(), which are joined. Not thread-safe.
class DisjointSets {
 public:
  // Makes `size` sets of one.
  void Reset(size_t size);
  // Returns whether they were two sets.
  bool Join(uint32_t a, uint32_t b);
  uint32_t Find(uint32_t element);
  size_t bytes() const { return parents_.bytes(); }

 private:
  ScratchArray<uint32_t> parents_;
};

// The buffers of one thread. Not thread-safe.
struct ForestScratch {
  DisjointSets sets;
  ScratchArray<uint32_t> outside;  // places of points of other parts, ascending

  size_t bytes() const { return sets.bytes() + outside.bytes(); }
};

// Leaves of `links`, each of which begins at a place in [first, last) and may end anywhere, those of a minimum spanning
// forest over all places that they touch, in the order of ComesBefore, and returns how many there are. A link that
// closes a circle of cheaper ones is in no tree of cheapest links of any larger graph, so that nothing is lost.
// Takes O(n log n), and O(n) most times: the cheapest links are sorted first, and most of the others are then within a
// set.
size_t KeepForest(NormalLink* links, size_t count, uint32_t first, uint32_t last, ForestScratch& scratch);

}  // namespace curvd
