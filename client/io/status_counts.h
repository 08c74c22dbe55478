// Counts what became of points.
#pragma once

#include <array>
#include <cstdint>

#include "client/io/point_status.h"

namespace curv {

// How many points have each PointStatus, by its value.
using StatusCounts = std::array<uint64_t, kStatusWords.size()>;

}  // namespace curv
