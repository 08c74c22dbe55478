// What the hexagram of nearest points keeps for each worker.
#pragma once

#include <cstddef>

#include "core/estimators/group_scratch.h"
#include "core/estimators/hexagram/corner_scratch.h"
#include "core/estimators/hexagram/hexagram.h"

namespace curvd {

struct HexagramScratch : MeasuringScratch {
  Hexagram hexagram;  // of each point of the group
  CornerScratch corners;

  void Fill(size_t i) {
    hexagram.Fill(i);
    measures.Fill(i);
  }
  size_t bytes() const override { return sizeof(*this) + search.bytes() + corners.bytes(); }
};

}  // namespace curvd
