// The extent of point records: what the index's build asks at every node.
#pragma once

#include "core/index/select_nth.h"
#include "core/index/spatial_index.h"

namespace curvd {

// Extends the box and lowers the lowest id of `node` so that they cover the records [first, last).
void ExtendNode(const PointRecord* first, const PointRecord* last, TreeNode& node);

}  // namespace curvd
