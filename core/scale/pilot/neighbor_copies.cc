#include "core/scale/pilot/neighbor_copies.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <tuple>

#include "core/base/copies.h"

namespace curvd {
namespace {

// Finds the copies among neighbors that are equally far away.
void MarkTiedCopies(std::span<const uint32_t> tied, PilotScratch& s) {
  const NeighborArrays& n = s.neighbors;
  const auto position = [&n](uint32_t j) { return std::tuple(n.dx[j], n.dy[j], n.dz[j]); };
  s.tied.assign(tied.begin(), tied.end());
  std::sort(s.tied.begin(), s.tied.end(), [&](uint32_t a, uint32_t b) {
    return std::tuple_cat(position(a), std::tuple(s.ids[a])) < std::tuple_cat(position(b), std::tuple(s.ids[b]));
  });
  for (size_t k = 1; k < s.tied.size(); ++k) {
    const uint32_t before = s.tied[k - 1], j = s.tied[k];
    if (position(before) == position(j)) s.ids[j] = ~FirstOfCopies(s.ids[before]);
  }
}

void MarkExactCopies(PilotScratch& s) {
  const std::span<const uint32_t> order = s.order;
  for (size_t first = 0; first < order.size();) {
    size_t last = first + 1;
    while (last < order.size() && s.squared[order[last]] == s.squared[order[first]]) ++last;
    if (last - first > 1) MarkTiedCopies(order.subspan(first, last - first), s);
    first = last;
  }
}

// Among so many of the nearest neighbors near copies are looked for first, and among so many before each in the order
// of distance.
constexpr size_t kLookedAt = 256, kMostBefore = 64;

// Calls visit(before, squared) for each neighbor before the k-th that may be as near to it as `most`, the last one
// first, until it returns true.
template <typename Visit>
void VisitNear(const PilotScratch& s, size_t k, float most, const Visit& visit) {
  const NeighborArrays& n = s.neighbors;
  const uint32_t j = s.order[k];
  const float least = std::sqrt(s.squared[j]) - most;
  for (size_t before = k; before > 0 && k - before < kMostBefore;) {
    const uint32_t i = s.order[--before];
    if (least > 0.0f && s.squared[i] < least * least) return;
    const float x = n.dx[i] - n.dx[j], y = n.dy[i] - n.dy[j], z = n.dz[i] - n.dz[j];
    if (visit(before, x * x + y * y + z * z)) return;
  }
}

void MarkNearCopies(PilotScratch& s) {
  const size_t looked_at = std::min(s.order.size(), kLookedAt);
  if (looked_at == 0) return;
  NearCopies copies(std::sqrt(s.squared[s.order[looked_at - 1]]), looked_at);
  if (!(copies.distance() > 0.0f)) return;
  for (size_t k = 1; k < looked_at; ++k) {
    VisitNear(s, k, copies.clearance(), [&](size_t, float squared) {
      copies.AddPair(squared);
      return false;
    });
  }
  if (!copies.Exist()) return;
  const float most = copies.distance() * copies.distance();
  // Exact copies as well: the first of them may be a near copy of another one.
  for (size_t k = 1; k < s.order.size(); ++k) {
    int32_t& id = s.ids[s.order[k]];
    VisitNear(s, k, copies.distance(), [&](size_t before, float squared) {
      if (squared <= most) id = ~FirstOfCopies(s.ids[s.order[before]]);
      return squared <= most;
    });
  }
}

}  // namespace

void MarkCopies(PilotScratch& s) {
  MarkExactCopies(s);
  MarkNearCopies(s);
}

}  // namespace curvd
