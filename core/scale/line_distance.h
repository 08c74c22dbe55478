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

// Takes away the estimates that too few lines tell, at points on lines: across lines a polynomial is told by one more
// of them than its degree, and by chance otherwise, on which neighborhoods of the same lines agree. Takes none away
// where less than half of the points lie on lines, where the bounds leave hardly a point an estimate that is told, or
// where small neighborhoods differ from larger ones along the lines, too: there they see what larger ones smooth away.
// Nor those of a method whose small neighborhoods are hardly farther from larger ones than these from each other.
// Thread-safe for distinct points. REQUIRES: the points are sampled ones.
void DropUntoldAcrossLines(const ScaleBounds& bounds, std::span<PilotPoint> points);

}  // namespace curvd
