// The part of a worker's scratch that every strategy uses.
#pragma once

#include <cstddef>

#include "core/estimators/frames.h"
#include "core/estimators/group_points.h"
#include "core/estimators/measures.h"
#include "core/estimators/strategy.h"
#include "core/search/search_scratch.h"

namespace curvd {

// Holds one group at a time: its points, then their neighborhoods, then their frames. What is left of the last group
// only seeds searches.
struct GroupScratch : WorkerScratch {
  SearchScratch search;
  GroupPoints points;
  GroupNeighborhoods neighborhoods;
  GroupFrames frames;
};

// For strategies that measure triangles.
struct MeasuringScratch : GroupScratch {
  GroupMeasures measures;
};

}  // namespace curvd
