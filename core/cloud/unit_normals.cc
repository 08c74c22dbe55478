#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/cloud/unit_normals.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/cloud/unit_normals-inl.h"
#include "hwy/highway.h"

#if HWY_ONCE

#include "core/cloud/unit_normals.h"

namespace curvd {

HWY_EXPORT(MakeUnitNormalsKernel);

void MakeUnitNormals(const char* positions, const char* normals, size_t count, double unit_tolerance,
                     UnitNormals& out) {
  HWY_DYNAMIC_DISPATCH(MakeUnitNormalsKernel)(positions, normals, count, unit_tolerance, out);
}

}  // namespace curvd

#endif  // HWY_ONCE
