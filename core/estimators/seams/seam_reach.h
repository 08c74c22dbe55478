// Tells which neighborhoods reach across a seam, and takes back the results of their points.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/estimators/curvature_field.h"
#include "core/estimators/options.h"
#include "core/estimators/seams/seam_marks.h"
#include "core/index/spatial_index.h"

namespace curvd {

// Finds neighborhoods that reach across a seam: that hold a marked point, and normals on the other side, which are more
// than a right angle from the point's own, or from that of a marked point: of the first in tree order, or of one of the
// two that turn farthest. Thread-safe while the marks do not change.
class SeamReach {
 public:
  // A point that gets a result. Lengths in the index's unit.
  struct Query {
    std::array<float, 3> position;
    std::array<float, 3> normal;
    size_t place;  // in the tree order
    size_t slot;
  };
  // The points of a group that get results, in tree order.
  struct Group {
    size_t size = 0;
    std::array<size_t, SpatialIndex::kGroupPoints> slots;
    std::array<bool, SpatialIndex::kGroupPoints> reaches;  // whether the result is OK, and reaches across a seam
  };

  // The neighborhoods are those of `options`. What it is given outlives the object.
  SeamReach(const EstimatorOptions& options, const SpatialIndex& index, const SeamMarks& marks);

  // Whether the neighborhood of a query up to `radius`, in the caller's unit, reaches across a seam. True also where so
  // many points tie that it takes too long to find out.
  bool Reaches(const Query& query, float radius) const;
  // What the results of a group's points are; those of marked points reach across nothing here. `results` are those of
  // the whole cloud, by slot.
  Group ReachingIn(size_t group, const PointCurvature* results) const;

 private:
  const SpatialIndex& index_;
  const SeamMarks& marks_;
  const size_t most_neighbors_;
};

// How many points lost each status, by PointStatus.
using RefusedCounts = std::array<uint64_t, kPointStatusEnd>;

// Gives PointStatus::kOpposedNormals to those points of a group that are marked, or are OK and have within the radius
// of their result both a marked point and normals on the other side: one that is more than a right angle from the
// point's own, or from that of a marked point. Of others, only points whose normals cancel out
// (kInconsistentNormals) change, if they are marked. Where many more points are as near as the last neighbor than
// the neighborhood holds, the point may be refused as well: that bounds the time. Adds what the points were to
// `refused`. `results` are those of the whole cloud, by slot, and hold the group's; their radii stay. Thread-safe for
// distinct groups and distinct `refused`.
void RefuseAtSeams(const EstimatorOptions& options, const SpatialIndex& index, const SeamMarks& marks, size_t group,
                   PointCurvature* results, RefusedCounts& refused);

}  // namespace curvd
