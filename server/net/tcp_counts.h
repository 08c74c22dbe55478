// Asks the system how many bytes went through a TCP connection.
#pragma once

#include <cstdint>

namespace curvd {

// All zero for a Unix socket, and where the system does not know.
struct TcpCounts {
  uint64_t received = 0;  // from the peer. The end of what a peer sends counts as one byte more.
  uint64_t sent = 0;      // to the peer, each byte once
};
TcpCounts CountsOf(int fd);

// Bytes that were received and that nobody has read.
uint64_t UnreadBytes(int fd);

}  // namespace curvd
