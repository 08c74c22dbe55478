// Of the links of a part of a cloud, those that a tree of cheapest links over the whole cloud may hold.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/scratch_array.h"
#include "core/normals/orientation/normal_links.h"

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

// Numbers places of a cloud: those in [first, last) from 0 on, then others in the order in which they are asked for.
// Not thread-safe.
class PlaceNumbers {
 public:
  // Forgets all places. At most `most_others` different ones outside [first, last) may be asked for.
  void Reset(uint32_t first, uint32_t last, size_t most_others);
  uint32_t Of(uint32_t place) { return place - first_ < size_inside_ ? place - first_ : OfOther(place); }
  // How many places have a number.
  size_t size() const { return size_inside_ + other_count_; }
  size_t bytes() const { return slots_.bytes(); }
  static constexpr size_t MostBytes(size_t most_others) {
    return ScratchArray<Slot>::MostBytes(4 * most_others + kFewestSlots);
  }

 private:
  // A table with open addresses, of which half are free.
  struct Slot {
    uint32_t place;
    uint32_t number;
  };
  static constexpr size_t kFewestSlots = 64;
  static constexpr uint32_t kFree = ~uint32_t{0};

  uint32_t OfOther(uint32_t place);

  uint32_t first_ = 0;
  uint32_t size_inside_ = 0;
  uint32_t other_count_ = 0;
  int shift_ = 0;  // of a hash to the number of a slot
  ScratchArray<Slot> slots_;
};

// The buffers of one thread. Not thread-safe.
struct ForestScratch {
  DisjointSets sets;
  PlaceNumbers numbers;
  ScratchArray<uint64_t> keys, sorted_keys;  // cost and index of each link
  ScratchArray<NormalLink> kept;

  size_t bytes() const { return sets.bytes() + numbers.bytes() + keys.bytes() + sorted_keys.bytes() + kept.bytes(); }
  // Bytes held at most for `links` links that begin at `places` places.
  static constexpr size_t MostBytes(size_t places, size_t links) {
    return ScratchArray<uint32_t>::MostBytes(places + links) + PlaceNumbers::MostBytes(links) +
           2 * ScratchArray<uint64_t>::MostBytes(links) + ScratchArray<NormalLink>::MostBytes(places + links);
  }
};

// Leaves of `links`, each of which begins at a place in [first, last) and may end anywhere, those of a minimum spanning
// forest over all places that they touch, in the order of ComesBefore, and returns how many there are. A link that
// closes a circle of cheaper ones is in no tree of cheapest links of any larger graph, so that nothing is lost.
// Takes O(n). REQUIRES: links ascend by a, then by b; there are fewer than 2^32, and no cost has a sign.
size_t KeepForest(NormalLink* links, size_t count, uint32_t first, uint32_t last, ForestScratch& scratch);

}  // namespace curvd
