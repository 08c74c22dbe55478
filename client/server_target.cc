#include "client/server_target.h"

#include <arpa/inet.h>

#include <algorithm>
#include <iterator>
#include <string_view>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"

namespace curv {
namespace {

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

// The scheme of a URL that is no target of gRPC, which would look it up as a part of a name: what people paste from a
// browser. Empty if it is none.
std::string_view SchemeOfUrl(std::string_view server) {
  const size_t end = server.find("://");
  if (end == std::string_view::npos || end == 0 || !absl::ascii_isalpha(static_cast<unsigned char>(server[0])))
    return {};
  const std::string_view scheme = server.substr(0, end);
  const bool is_word = std::all_of(scheme.begin(), scheme.end(), [](unsigned char c) {
    return absl::ascii_isalnum(c) || c == '+' || c == '.' || c == '-';
  });
  static constexpr std::string_view kTargets[] = {"dns", "ipv4", "ipv6", "unix", "unix-abstract", "vsock", "xds"};
  const bool is_target = std::find(std::begin(kTargets), std::end(kTargets), scheme) != std::end(kTargets);
  return is_word && !is_target ? scheme : std::string_view();
}

absl::Status CheckNoUrl(const std::string& server) {
  const std::string scheme(SchemeOfUrl(server));
  if (scheme.empty()) return absl::OkStatus();
  const bool has_tls = absl::EqualsIgnoreCase(scheme, "https") || absl::EqualsIgnoreCase(scheme, "grpcs");
  return absl::InvalidArgumentError(
      absl::StrCat("server \"", server, "\" is a URL; it must be HOST or HOST:PORT, as in 127.0.0.1:50061, without ",
                   scheme, "://", has_tls ? ": TLS has an option of its own" : ""));
}

bool LooksLikeTarget(const std::string& target) {
  const size_t colon = target.rfind(':');
  return colon != std::string::npos && colon > 0 && colon + 1 < target.size() && target.back() != '/';
}

absl::Status CheckPort(const std::string& target) {
  for (const char* kind : {"unix:", "unix-abstract:", "vsock:", "xds:"}) {
    if (absl::StartsWith(target, kind)) return absl::OkStatus();
  }
  const std::string port = target.substr(target.rfind(':') + 1);
  uint32_t number;
  const bool is_port = absl::SimpleAtoi(port, &number) && number >= 1 && number <= 65535;
  return is_port ? absl::OkStatus()
                 : absl::InvalidArgumentError(
                       absl::StrCat("server \"", target, "\" has port \"", port, "\"; it must be from 1 to 65535"));
}

absl::StatusOr<std::string> ReadTarget(absl::string_view server) {
  const std::string stripped(absl::StripAsciiWhitespace(server));
  if (absl::Status status = CheckNoUrl(stripped); !status.ok()) return status;
  std::string target = WithDefaultPort(stripped);
  if (!LooksLikeTarget(target)) {
    return absl::InvalidArgumentError(
        absl::StrCat("server \"", target, "\" is neither HOST nor HOST:PORT, as in 127.0.0.1:50061"));
  }
  if (absl::Status status = CheckPort(target); !status.ok()) return status;
  return target;
}

}  // namespace

absl::StatusOr<std::vector<std::string>> ReadServerTargets(absl::string_view servers) {
  std::vector<std::string> targets;
  for (const absl::string_view part : absl::StrSplit(servers, ',')) {
    absl::StatusOr<std::string> target = ReadTarget(part);
    if (!target.ok()) return target.status();
    targets.push_back(*std::move(target));
  }
  return targets;
}

}  // namespace curv
