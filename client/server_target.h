// Reads where a server is, as --server and Connect take it.
#pragma once

#include <string>

namespace curv {

// Adds the default port, 50061, to a host, an address of IPv6 or a name for dns: that has none. All else stays as it
// is.
std::string WithDefaultPort(const std::string& server);

// Whether `target` has a host and a port, or a scheme and what follows it: "localhost:50061", "unix:/run/curvd".
bool LooksLikeTarget(const std::string& target);

}  // namespace curv
