// Tells whose connection it was that has ended.
#pragma once

#include <chrono>
#include <optional>

#include "server/net/connection_registry.h"
#include "server/observe/security_metrics.h"

namespace curvd {

// Why the guard ended the connection, or else why a connection that has ended after `age` was a stranger's; nullopt if
// it was not: a call was let in from it, it
// asked for what everybody may ask (health), or it came through a Unix socket, whose callers cannot be told apart.
// `handshake_timeout` is after how long gRPC gives up on a handshake.
std::optional<StrangerReason> WhyStranger(const ConnectionRecord& connection, std::chrono::steady_clock::duration age,
                                          std::chrono::steady_clock::duration handshake_timeout);

}  // namespace curvd
