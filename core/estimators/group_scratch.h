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
  SearchScratch search;  // counts the work of strategies, too
  GroupPoints points;
  GroupNeighborhoods neighborhoods;
  GroupFrames frames;

  uint64_t work() const final { return search.work; }

  // Whether the run that began at this work has taken so much that it leaves the rest of its group to another one.
  bool IsLongSince(uint64_t began) const { return search.work - began > most_work; }

  // Ends the group with its first `count` points, which are done; another run begins with the next one.
  void LeaveRest(size_t count) {
    rest = first_point + count;
    points.size = count;
    for (size_t i = count; i < SpatialIndex::kGroupPoints; ++i) frames.Fill(i);
  }

  // For a run that takes on some points of a group alone: if it has ended early, the next run begins after the last of
  // `points`, also with regard to the points between them.
  void LeaveRestAfterLast(size_t group) {
    if (rest > 0) rest = static_cast<size_t>(points.place[points.size - 1]) + 1 - group * SpatialIndex::kGroupPoints;
  }
};

// For strategies that measure triangles.
struct MeasuringScratch : GroupScratch {
  GroupMeasures measures;
};

}  // namespace curvd
