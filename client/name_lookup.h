// Looks up the addresses of a host.
#pragma once

#include <netinet/in.h>

#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace curv {

struct Address {
  sockaddr_storage bytes = {};
  socklen_t size = 0;
  std::string text;  // "127.0.0.1:50061", "[::1]:50061"
};

// The addresses of a host in the order in which the system prefers them, each once. NOT_FOUND, with the system's words,
// if it has none. `port` is a number. Waits for name servers as long as the system does.
absl::StatusOr<std::vector<Address>> LookUp(const std::string& host, const std::string& port);

}  // namespace curv
