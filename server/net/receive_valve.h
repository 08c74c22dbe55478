// Has the system bound how many bytes a connection may receive.
#pragma once

#include <cstdint>
#include <optional>

namespace curvd {

// What arrives faster than anybody looks at it must be bounded by the system. A filter on the socket cuts off, unread
// and without memory, whatever lies beyond a position in the stream of bytes; TCP sends it again later. No privilege is
// needed. Nothing here is thread-safe for one socket, and all of it is for different ones.

// Has connections that `listener` accepts from now on know where their stream begins. No effect where that is not
// known.
void RememberBeginnings(int listener);

// The sequence number of the first byte that the peer of `fd` sends, once; or nullopt if the system does not know: for
// a Unix socket, after SYN cookies, or if the listener had not been told.
std::optional<uint32_t> BeginningOf(int fd);

// From now on no byte from the `bytes`th on is received, given what BeginningOf returned. Bytes that have been received
// already stay. Returns whether the system does so.
// REQUIRES: the peer has sent less than 2^31 bytes more or less than that.
bool BoundReceived(int fd, uint32_t beginning, uint64_t bytes);

// Takes the bound away. The peer's system sends again what was cut off, at most about as long after that as it was cut
// off, a round trip and 200 milliseconds.
void LiftBound(int fd);

}  // namespace curvd
