#include "client/tiles/sample.h"

#include <algorithm>

namespace curv {

void PointSample::Shrink() {
  if (kept_.size() <= size_) return;
  const auto less = [](const Kept& a, const Kept& b) { return a.first < b.first; };
  const auto end = kept_.begin() + static_cast<ptrdiff_t>(size_);
  std::nth_element(kept_.begin(), end, kept_.end(), less);
  limit_ = end->first;
  kept_.resize(size_);
}

std::vector<Position> PointSample::Take(size_t most) {
  size_ = std::min(size_, most);
  Shrink();
  std::sort(kept_.begin(), kept_.end(), [](const Kept& a, const Kept& b) { return a.first < b.first; });
  std::vector<Position> positions;
  positions.reserve(kept_.size());
  for (const Kept& kept : kept_) positions.push_back(kept.second);
  kept_ = {};
  return positions;
}

}  // namespace curv
