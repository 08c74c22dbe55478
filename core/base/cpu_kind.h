// Which instruction set the kernels run on.
#pragma once

#include <string>

namespace curvd {

// Name of the best instruction set that this machine has and this build contains, such as "AVX2".
std::string CpuKind();

}  // namespace curvd
