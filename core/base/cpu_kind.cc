#include "core/base/cpu_kind.h"

#include "hwy/highway.h"

namespace curvd {

std::string CpuKind() {
  const int64_t supported = hwy::SupportedTargets() & HWY_TARGETS;
  return hwy::TargetName(supported & -supported);  // the lowest bit is the best target
}

}  // namespace curvd
