#include "core/umbrella.h"

namespace curvd {
namespace {

// Whether the umbrella has the triangle over `a` and `b`, whichever way round: normals may face opposite sides.
bool HasTriangle(const Umbrella& umbrella, int32_t a, int32_t b) {
  const int32_t* rim = umbrella.rim;
  for (int i = 0; i < Umbrella::kMaxTriangles && rim[i + 1] != Umbrella::kNone; ++i) {
    if ((rim[i] == a && rim[i + 1] == b) || (rim[i] == b && rim[i + 1] == a)) return true;
  }
  return false;
}

}  // namespace

void CountOccurrences(Umbrella* umbrellas, size_t slot) {
  Umbrella& umbrella = umbrellas[slot];
  const auto point = static_cast<int32_t>(slot);
  umbrella.occurrences = 0;
  for (int i = 0; i < Umbrella::kMaxTriangles && umbrella.rim[i + 1] != Umbrella::kNone; ++i) {
    const int32_t a = umbrella.rim[i], b = umbrella.rim[i + 1];
    const bool at_a = HasTriangle(umbrellas[a], b, point), at_b = HasTriangle(umbrellas[b], point, a);
    if ((at_a && a < point) || (at_b && b < point)) continue;
    umbrella.occurrences |= static_cast<uint32_t>(1 + at_a + at_b) << (2 * i);
  }
}

}  // namespace curvd
