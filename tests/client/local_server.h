// A curvd in this process, for tests of clients.
#pragma once

#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "server/curvature_server.h"

namespace curv {

// Loopback, on a port that the system picks, two threads, no log; else as `changes` say.
inline std::unique_ptr<curvd::CurvatureServer> StartServer(const curvd::ServerOptions& changes = {}) {
  curvd::ServerOptions options = changes;
  options.listen = "127.0.0.1:0";
  options.metrics_listen = "";
  options.threads = 2;
  options.log = false;
  return *curvd::CurvatureServer::Create(options);
}

inline std::string AddressOf(int port) { return absl::StrCat("127.0.0.1:", port); }

}  // namespace curv
