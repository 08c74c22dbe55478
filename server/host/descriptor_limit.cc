#include "server/host/descriptor_limit.h"

#include <sys/resource.h>

#include <algorithm>

namespace curvd {

void RaiseDescriptorLimit() {
  rlimit limit = {};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
}

size_t ConnectionsWithin(size_t wanted) {
  rlimit limit = {};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return wanted;
  constexpr rlim_t kPerConnection = 2;
  return std::min<size_t>(wanted, std::max<size_t>(1, (limit.rlim_cur - limit.rlim_cur / 10) / kPerConnection));
}

}  // namespace curvd
