// How soon a peer that vanished is noticed.
#pragma once

namespace curvd {

// gRPC asks a peer that has been silent for this long,
inline constexpr int kKeepaliveTimeMs = 10'000;
// and waits this long for its answer.
inline constexpr int kKeepaliveTimeoutMs = 5'000;

}  // namespace curvd
