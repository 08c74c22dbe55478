#include "client/server_target.h"

#include <arpa/inet.h>

#include <algorithm>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"

namespace curv {

std::string WithDefaultPort(const std::string& server) {
  constexpr char kDefaultPort[] = ":50061";
  in6_addr address;
  if (inet_pton(AF_INET6, server.c_str(), &address) == 1) return absl::StrCat("[", server, "]", kDefaultPort);
  const bool is_dns = absl::StartsWith(server, "dns:");
  const size_t name_at = is_dns ? std::max(server.rfind('/') + 1, size_t{4}) : 0;
  const std::string name = server.substr(name_at);
  const bool has_port = absl::StrContains(name, ':') && !absl::EndsWith(name, "]");
  return name.empty() || has_port ? server : absl::StrCat(server, kDefaultPort);
}

bool LooksLikeTarget(const std::string& target) {
  const size_t colon = target.rfind(':');
  return colon != std::string::npos && colon > 0 && colon + 1 < target.size() && target.back() != '/';
}

}  // namespace curv
