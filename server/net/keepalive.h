// Decides how soon a peer that vanished is noticed.
#pragma once

namespace curvd {

// While a call is open, gRPC asks a peer that has been silent for this long,
inline constexpr int kKeepaliveTimeMs = 10'000;
// and waits this long for its answer.
inline constexpr int kKeepaliveTimeoutMs = 5'000;
// How often a client may ask the same of the server, with or without a call.
inline constexpr int kClientsPingIntervalMs = 5'000;

}  // namespace curvd
