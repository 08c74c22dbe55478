#include "server/host/thread_stacks.h"

#include <pthread.h>

#include <cstddef>

namespace curvd {

void LimitThreadStacks() {
#ifdef __GLIBC__
  constexpr size_t kStackBytes = 2 << 20;
  pthread_attr_t attributes;
  if (pthread_attr_init(&attributes) != 0) return;
  if (pthread_attr_setstacksize(&attributes, kStackBytes) == 0) pthread_setattr_default_np(&attributes);
  pthread_attr_destroy(&attributes);
#endif
}

}  // namespace curvd
