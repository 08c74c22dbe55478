#include "client/cli/doctor/examine.h"

#include <cstdlib>
#include <optional>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "client/cli/doctor/answers.h"
#include "client/cli/doctor/socket.h"
#include "client/cli/doctor/transport.h"

namespace curv {
namespace {

struct HostAndPort {
  std::string host;
  std::string port;
};

// Nothing for targets that name no host, such as unix:PATH and ipv4:LIST.
std::optional<HostAndPort> Split(std::string target) {
  if (absl::StartsWith(target, "dns:")) target = target.substr(std::max(target.rfind('/') + 1, size_t{4}));
  for (const char* scheme : {"unix:", "unix-abstract:", "ipv4:", "ipv6:", "vsock:", "xds:"}) {
    if (absl::StartsWith(target, scheme)) return std::nullopt;
  }
  const size_t colon = target.rfind(':');
  std::string host = target.substr(0, colon);
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
  return HostAndPort{std::move(host), target.substr(colon + 1)};
}

// Calls go through a proxy where the environment names one (gRPC's rules), and these checks do not.
void NoteProxy(Findings& findings) {
  for (const char* variable : {"grpc_proxy", "https_proxy", "http_proxy"}) {
    const char* value = std::getenv(variable);
    if (value == nullptr || *value == '\0') continue;
    findings.Warn("proxy",
                  absl::StrCat("the variable ", variable, " sends calls through a proxy, which these checks go past"),
                  "if calls fail that shall not go there, name the server in the variable no_grpc_proxy");
    return;
  }
}

struct Unreachable {
  std::string address;
  std::string why;
  bool refused;
};

std::string RemedyFor(const std::vector<Unreachable>& all) {
  for (const Unreachable& each : all) {
    if (each.refused) {
      return "start curvd there, or ask another port: it listens on 127.0.0.1:50061 unless --listen says otherwise";
    }
  }
  return "look for a firewall, and whether the machine is up: curvd must listen on an address that is reached from "
         "here";
}

// The addresses that take connections.
std::vector<Address> Connectable(const std::string& host, const std::vector<Address>& addresses, absl::Duration timeout,
                                 Findings& findings) {
  std::vector<Address> reached;
  std::vector<Unreachable> failed;
  for (const Address& address : addresses) {
    const absl::Status status = Socket::Connect(address, timeout).status();
    if (status.ok()) {
      reached.push_back(address);
      continue;
    }
    const std::string why = absl::IsUnavailable(status) ? "refuses connections: nothing listens there"
                            : absl::IsDeadlineExceeded(status)
                                ? absl::StrCat("does not answer within ", absl::FormatDuration(timeout))
                                : std::string(status.message());
    failed.push_back({address.text, why, absl::IsUnavailable(status)});
  }
  const std::string failures = absl::StrJoin(failed, "; ", [](std::string* out, const Unreachable& each) {
    absl::StrAppend(out, each.address, " ", each.why);
  });
  const std::string successes =
      absl::StrJoin(reached, ", ", [](std::string* out, const Address& each) { absl::StrAppend(out, each.text); });
  if (failed.empty()) {
    findings.Ok("connection",
                absl::StrCat(successes, reached.size() == 1 ? " takes connections" : " take connections"));
  } else if (reached.empty()) {
    findings.Fault("connection", failures, RemedyFor(failed));
  } else if (host == "localhost") {
    findings.Ok("connection", absl::StrCat(successes, " takes connections; calls pass over ", failed.front().address));
  } else {
    findings.Warn("connection", absl::StrCat(successes, " answers, but ", failures),
                  "calls pass over it; start curvd there, or take the address from the name");
  }
  return reached;
}

}  // namespace

Findings Examine(const std::string& target, const ExamineOptions& options) {
  Findings findings;
  const std::optional<HostAndPort> place = Split(target);
  if (!place) {
    findings.Ok("name", absl::StrCat(target, " is taken as it is: connections are left to gRPC"));
    AskWhatItSays(target, "", options, findings);
    return findings;
  }
  NoteProxy(findings);
  const absl::StatusOr<std::vector<Address>> addresses = LookUp(place->host, place->port);
  if (!addresses.ok()) {
    findings.Fault("name", absl::StrCat(place->host, " has no address: ", addresses.status().message()),
                   "check the spelling, and with `getent hosts NAME` whether this machine can look up names at all");
    return findings;
  }
  findings.Ok("name", absl::StrCat(place->host, " is ",
                                   absl::StrJoin(*addresses, ", ", [](std::string* out, const Address& each) {
                                     absl::StrAppend(out, each.text.substr(0, each.text.rfind(':')));
                                   })));
  const std::vector<Address> reached = Connectable(place->host, *addresses, options.timeout, findings);
  for (const Address& address : reached) {
    // Lines of several replicas must not be mistaken for each other.
    const std::string prefix = reached.size() > 1 ? absl::StrCat(address.text, ": ") : "";
    if (!LookAtTransport(address, place->host, prefix, options, findings)) continue;
    ExamineOptions own = options;
    // The certificate is for the name, not for the address that it stands for.
    if (own.connect.tls && own.connect.server_name.empty()) own.connect.server_name = place->host;
    AskWhatItSays(address.text, prefix, own, findings);
  }
  return findings;
}

}  // namespace curv
