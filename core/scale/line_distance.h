// Lines on which scanners leave points.
#pragma once

#include <array>
#include <span>

#include "core/scale/pilot/pilot_scratch.h"
#include "core/scale/pilot/pilot_table.h"
#include "core/scale/scale_choice.h"

namespace curvd {

struct PointLine {
  double distance = 0.0;              // to the next line, in the index's unit; 0: the point lies on none
  std::array<double, 3> direction{};  // along the point's own, of unit length
};

// The line of the sampled point of the moment, as seen in the tangent plane of these axes: noise along the normal makes
// lines no wider. REQUIRES: s.order, s.squared and the copies are those of the point; the axes have unit length and are
// at right angles.
PointLine LineOf(const PilotScratch& s, const std::array<double, 3>& x_axis, const std::array<double, 3>& y_axis);

// Drops estimates of points on lines whose neighborhoods hold too few lines. Across lines, one more of them than its
// degree determines a polynomial. With fewer of them chance decides, and neighborhoods of the same lines agree on what
// it decides. All estimates are kept
// - where less than half of the points lie on lines;
// - where the bounds leave hardly a point an estimate that is determined;
// - where small neighborhoods differ from larger ones along the lines as well: they see what larger ones smooth away;
// - of a method whose small neighborhoods are hardly farther from larger ones than these are from each other.
// Thread-safe for distinct points. REQUIRES: the points are sampled ones.
void DropUndeterminedAcrossLines(const ScaleBounds& bounds, std::span<PilotPoint> points);

}  // namespace curvd
