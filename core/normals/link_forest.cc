#include "core/normals/link_forest.h"

#include <algorithm>

namespace curvd {
namespace {

// Numbers places: those of the part first, then those outside.
class PlaceNumbers {
 public:
  PlaceNumbers(const NormalLink* links, size_t count, uint32_t first, uint32_t last, ScratchArray<uint32_t>& outside)
      : first_(first), last_(last), outside_(outside) {
    for (size_t i = 0; i < count; ++i) {
      if (IsInside(links[i].b)) continue;
      outside_.Reserve(outside_count_ + 1);
      outside_[outside_count_++] = links[i].b;
    }
    std::sort(outside_.data(), outside_.data() + outside_count_);
    outside_count_ =
        static_cast<size_t>(std::unique(outside_.data(), outside_.data() + outside_count_) - outside_.data());
  }

  size_t size() const { return last_ - first_ + outside_count_; }
  uint32_t of(uint32_t place) const {
    if (IsInside(place)) return place - first_;
    const uint32_t* const begin = outside_.data();
    return last_ - first_ + static_cast<uint32_t>(std::lower_bound(begin, begin + outside_count_, place) - begin);
  }

 private:
  bool IsInside(uint32_t place) const { return place >= first_ && place < last_; }

  uint32_t first_;
  uint32_t last_;
  ScratchArray<uint32_t>& outside_;
  size_t outside_count_ = 0;
};

}  // namespace

void DisjointSets::Reset(size_t size) {
  parents_.Reserve(size);
  for (size_t i = 0; i < size; ++i) parents_[i] = static_cast<uint32_t>(i);
}

uint32_t DisjointSets::Find(uint32_t element) {
  while (parents_[element] != element) {
    parents_[element] = parents_[parents_[element]];
    element = parents_[element];
  }
  return element;
}

bool DisjointSets::Join(uint32_t a, uint32_t b) {
  a = Find(a);
  b = Find(b);
  if (a == b) return false;
  parents_[std::max(a, b)] = std::min(a, b);
  return true;
}

size_t KeepForest(NormalLink* links, size_t count, uint32_t first, uint32_t last, ForestScratch& scratch) {
  const PlaceNumbers numbers(links, count, first, last, scratch.outside);
  scratch.sets.Reset(numbers.size());
  size_t kept = 0;
  // A tree has a link less than points: as many of the cheapest make most of it.
  for (size_t begin = 0; begin < count;) {
    const size_t end = std::min(begin + 2 * numbers.size(), count);
    std::nth_element(links + begin, links + end - 1, links + count, ComesBefore);
    std::sort(links + begin, links + end, ComesBefore);
    for (size_t i = begin; i < end; ++i) {
      if (scratch.sets.Join(numbers.of(links[i].a), numbers.of(links[i].b))) links[kept++] = links[i];
    }
    count = static_cast<size_t>(std::remove_if(links + end, links + count,
                                               [&](const NormalLink& link) {
                                                 return scratch.sets.Find(numbers.of(link.a)) ==
                                                        scratch.sets.Find(numbers.of(link.b));
                                               }) -
                                links);
    begin = end;
  }
  return kept;
}

}  // namespace curvd
