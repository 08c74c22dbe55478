#include "client/connect_options.h"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <algorithm>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"

namespace curv {
namespace {

// curvd takes 8 KiB of metadata unless told otherwise.
constexpr size_t kMaxTokenBytes = 4096;

bool IsPem(const std::string& text) { return absl::StrContains(text, "-----BEGIN "); }

struct Symptom {
  const char* text;
  const char* meaning;
};

// The first that matches counts.
constexpr Symptom kTlsSymptoms[] = {
    {"Hostname Verification Check failed",
     "the server's certificate is not for the name that was asked for (--server, --server-name)"},
    {"is not in peer certificate",
     "the server's certificate is not for the name that was asked for (--server, --server-name)"},
    {"certificate verify failed",
     "the server's certificate has expired, or is of an authority that this client does not trust (--ca)"},
    {"wrong version number", "the server speaks plain text on this port: leave out --tls, or ask another port"},
    {"WRONG_VERSION_NUMBER", "the server speaks plain text on this port: leave out --tls, or ask another port"},
};

// Whether no connection came about because the server would not have it.
bool WasTurnedAway(const std::string& message) {
  const bool never_connected = absl::StrContains(message, "failed to connect") ||
                               absl::StrContains(message, "connections to all backends failing");
  if (!never_connected) return false;
  return absl::StrContains(message, "Socket closed") || absl::StrContains(message, "Connection reset") ||
         absl::StrContains(message, "Broken pipe") || absl::StrContains(message, "Handshake read failed") ||
         absl::StrContains(message, "Endpoint closing");
}

}  // namespace

absl::Status CheckConnectOptions(const ConnectOptions& options) {
  const bool has_tls_options = !options.authorities.empty() || !options.certificate.empty() ||
                               !options.private_key.empty() || !options.server_name.empty();
  if (has_tls_options && !options.tls) {
    return absl::InvalidArgumentError("authorities, certificate, key and server name are of use with TLS only");
  }
  if (options.certificate.empty() != options.private_key.empty()) {
    return absl::InvalidArgumentError("a client certificate and its private key are of use together only");
  }
  if (!options.authorities.empty() && !IsPem(options.authorities)) {
    return absl::InvalidArgumentError("the authorities (--ca) are not PEM");
  }
  if (!options.certificate.empty() && (!IsPem(options.certificate) || !IsPem(options.private_key))) {
    return absl::InvalidArgumentError("the client certificate (--cert) or its key (--key) is not PEM");
  }
  return CheckToken(options.token);
}

absl::Status CheckToken(const std::string& token) {
  if (token.size() > kMaxTokenBytes) {
    return absl::InvalidArgumentError(
        absl::StrCat("the token has ", token.size(), " bytes; it must have at most ", kMaxTokenBytes));
  }
  const bool is_printable = std::all_of(token.begin(), token.end(), [](char c) { return c > ' ' && c <= '~'; });
  if (!is_printable) return absl::InvalidArgumentError("the token must be printable ASCII without blanks");
  return absl::OkStatus();
}

bool IsLocalTarget(const std::string& target) {
  if (absl::StartsWith(target, "unix:") || absl::StartsWith(target, "localhost:") ||
      absl::StartsWith(target, "[::1]:")) {
    return true;
  }
  in_addr v4 = {};
  return inet_pton(AF_INET, target.substr(0, target.rfind(':')).c_str(), &v4) == 1 && ntohl(v4.s_addr) >> 24 == 127;
}

absl::Status ExplainConnectError(const absl::Status& status, bool tls, bool has_certificate) {
  if (!absl::IsUnavailable(status)) return status;
  const std::string message(status.message());
  std::string meaning;
  if (tls) {
    for (const Symptom& symptom : kTlsSymptoms) {
      if (!absl::StrContains(message, symptom.text)) continue;
      meaning = symptom.meaning;
      break;
    }
  }
  if (meaning.empty() && WasTurnedAway(message)) {
    meaning = !tls              ? "the server may speak TLS only (--tls), or has too many connections"
              : has_certificate ? "the server may not accept this client's certificate, or has too many connections"
                                : "the server may ask for a client certificate (--cert, --key)";
  }
  if (meaning.empty()) return status;
  absl::Status explained(status.code(), absl::StrCat(meaning, ": ", message));
  status.ForEachPayload(
      [&explained](absl::string_view url, const absl::Cord& payload) { explained.SetPayload(url, payload); });
  return explained;
}

}  // namespace curv
