// Takes addresses apart: where a server listens, who can reach it there, and whose connection it is.
#pragma once

#include <string>

namespace curvd {

// Whether only this machine can reach `listen`: a loopback address ("127.0.0.1:0", "[::1]:50061", "localhost:50061"), a
// Unix socket ("unix:PATH"), or "" (nowhere). Any other name counts as public, whatever it may resolve to.
bool IsLocalAddress(const std::string& listen);

// The host and the port of "HOST:PORT", with the brackets of an IPv6 address taken off; both are empty if there is no
// colon.
struct HostPort {
  std::string host;
  std::string port;
};
HostPort SplitHostPort(const std::string& address);

// Whom a peer's limits apply to: the address of "ipv4:10.0.0.7:1234", the first 64 bits of an IPv6 address (what one
// subscriber usually has), "unix", or `peer` itself if it is none of these. `peer` is as gRPC writes it, brackets
// percent-encoded or not.
std::string PeerAddress(const std::string& peer);

}  // namespace curvd
