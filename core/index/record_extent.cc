#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/index/record_extent.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/index/record_extent-inl.h"
#include "hwy/highway.h"

#if HWY_ONCE

#include "core/index/record_extent.h"

namespace curvd {

HWY_EXPORT(ExtendNodeKernel);

void ExtendNode(const PointRecord* first, const PointRecord* last, TreeNode& node) {
  HWY_DYNAMIC_DISPATCH(ExtendNodeKernel)(first, last, node);
}

}  // namespace curvd

#endif  // HWY_ONCE
