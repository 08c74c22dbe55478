#pragma once

#include <sys/socket.h>

namespace curvd {

// Sets an option of a socket, as setsockopt(2) does. What fails is left as it was: all that use this can do without.
inline void SetSocketOption(int fd, int level, int option, int value) {
  setsockopt(fd, level, option, &value, sizeof(value));
}

}  // namespace curvd
