// Looks at a server from outside, step by step, as a call would come to it.
#pragma once

#include <string>

#include "absl/time/time.h"
#include "client/cli/doctor/findings.h"
#include "client/connect_options.h"

namespace curv {

struct ExamineOptions {
  ConnectOptions connect;
  absl::Duration timeout;      // of each step
  std::string client_version;  // "0.1.0"
};

// Looks up the name of `target` ("HOST:PORT", or another target of gRPC), connects to each of its addresses, finds out
// what is spoken there, looks at the certificate where options ask for TLS, and asks for version, health, limits and
// time. What cannot be looked at because of a fault is left out.
Findings Examine(const std::string& target, const ExamineOptions& options);

}  // namespace curv
