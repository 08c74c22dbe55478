#include "server/net/listen_address.h"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <algorithm>
#include <iterator>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"

namespace curvd {
namespace {

bool IsLoopback(const std::string& host) {
  in_addr v4 = {};
  if (inet_pton(AF_INET, host.c_str(), &v4) == 1) return ntohl(v4.s_addr) >> 24 == 127;
  in6_addr v6 = {};
  return inet_pton(AF_INET6, host.c_str(), &v6) == 1 && IN6_IS_ADDR_LOOPBACK(&v6);
}

std::string FirstHalf(const in6_addr& address) {
  in6_addr network = {};
  std::copy_n(std::begin(address.s6_addr), 8, std::begin(network.s6_addr));
  char text[INET6_ADDRSTRLEN];
  return absl::StrCat(inet_ntop(AF_INET6, &network, text, sizeof(text)), "/64");
}

}  // namespace

HostPort SplitHostPort(const std::string& address) {
  const size_t colon = address.rfind(':');
  if (colon == std::string::npos) return {};
  HostPort split{address.substr(0, colon), address.substr(colon + 1)};
  if (split.host.size() >= 2 && split.host.front() == '[' && split.host.back() == ']') {
    split.host = split.host.substr(1, split.host.size() - 2);
  }
  return split;
}

bool IsLocalAddress(const std::string& listen) {
  if (listen.empty() || absl::StartsWith(listen, "unix:")) return true;
  const std::string host = SplitHostPort(listen).host;
  return host == "localhost" || IsLoopback(host);
}

std::string PeerAddress(const std::string& peer) {
  if (absl::StartsWith(peer, "unix:")) return "unix";
  const size_t scheme = peer.find(':');
  if (!absl::StartsWith(peer, "ipv4:") && !absl::StartsWith(peer, "ipv6:")) return peer;
  std::string host =
      SplitHostPort(absl::StrReplaceAll(peer.substr(scheme + 1), {{"%5B", "["}, {"%5D", "]"}, {"%25", "%"}})).host;
  host = host.substr(0, host.find('%'));  // the zone of a link-local address
  in6_addr v6 = {};
  if (inet_pton(AF_INET6, host.c_str(), &v6) != 1) return host;
  if (!IN6_IS_ADDR_V4MAPPED(&v6)) return FirstHalf(v6);
  char text[INET_ADDRSTRLEN];
  return inet_ntop(AF_INET, &v6.s6_addr[12], text, sizeof(text));
}

}  // namespace curvd
