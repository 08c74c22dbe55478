#include "client/cli/connection_flags.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/string_view.h"
#include "client/cli/flags.h"
#include "client/cli/pem/pem_checks.h"
#include "client/server_target.h"
#include "proto/access_list.h"

namespace curv {
namespace {

absl::Status ReadFile(const char* flag, const std::string& path, std::string& text) {
  if (path.empty()) return absl::OkStatus();
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  text.assign(std::istreambuf_iterator<char>(file), {});
  if (file.is_open() && !text.empty()) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(flag, ": ", path, ": ", errno == 0 ? "the file is empty" : std::strerror(errno)));
}

// Whether the text is that of the server's file of tokens.
bool HoldsHashes(const std::string& text) {
  const auto entries = curvd::ParseTokenFile(text);
  return entries.ok() && !entries->empty();
}

absl::Status CheckPemFiles(const ConnectionFlags& flags, const ConnectOptions& options) {
  absl::Status status;
  if (!flags.ca_file.empty()) status = CheckCertificate("--ca", flags.ca_file, options.authorities);
  if (status.ok() && !flags.cert_file.empty())
    status = CheckCertificate("--cert", flags.cert_file, options.certificate);
  if (status.ok() && !flags.cert_file.empty() && !flags.key_file.empty()) {
    status = CheckPrivateKey("--key", flags.key_file, options.private_key, options.certificate);
  }
  return status;
}

// The environment variable that a flag may come from: CURV_TOKEN_FILE of --token-file.
std::string VariableOf(absl::string_view flag) {
  return absl::StrCat("CURV_", absl::AsciiStrToUpper(absl::StrReplaceAll(flag.substr(2), {{"-", "_"}})));
}

CLI::Validator Servers() {
  return CLI::Validator([](std::string& text) { return std::string(ReadServerTargets(text).status().message()); }, "");
}

}  // namespace

void AddConnectionFlags(CLI::App& command, ConnectionFlags& flags) {
  const auto file = [&command](const char* flag, std::string& value, const char* help) {
    command.add_option(flag, value, help)->envname(VariableOf(flag))->option_text("FILE");
  };
  command.add_option("--server", flags.server, "HOST:PORT of curvd, or several with commas between [in this process]")
      ->check(NotEmpty())
      ->check(Servers())
      ->option_text("LIST");
  command.add_flag("--tls", flags.tls, "encrypt, and check the server's certificate; implied by --ca and --cert")
      ->envname(VariableOf("--tls"));
  file("--ca", flags.ca_file, "authorities of the server's certificate, PEM [those of the system]");
  file("--cert", flags.cert_file, "certificate to show to the server, PEM");
  file("--key", flags.key_file, "its private key, PEM");
  command.add_option("--server-name", flags.server_name, "name in the server's certificate [the host of --server]")
      ->envname(VariableOf("--server-name"))
      ->option_text("NAME");
  file("--token-file", flags.token_file, "bearer token to send [the variable CURV_TOKEN]");
  command
      .add_flag("--send-token-in-plain-text", flags.send_token_in_plain_text,
                "send the token to other machines even without TLS")
      ->envname(VariableOf("--send-token-in-plain-text"));
}

absl::Status CheckNoneNeedsAServer(const ConnectionFlags& flags) {
  if (!flags.server.empty()) return absl::OkStatus();
  const std::pair<const char*, bool> given[] = {
      {"--tls", flags.tls},
      {"--ca", !flags.ca_file.empty()},
      {"--cert", !flags.cert_file.empty()},
      {"--key", !flags.key_file.empty()},
      {"--server-name", !flags.server_name.empty()},
      {"--token-file", !flags.token_file.empty()},
      {"--send-token-in-plain-text", flags.send_token_in_plain_text},
  };
  for (const auto& [flag, is_given] : given) {
    if (is_given && std::getenv(VariableOf(flag).c_str()) == nullptr) {
      return absl::InvalidArgumentError(absl::StrCat(flag, ": needs --server; without it, this process estimates"));
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<ConnectOptions> ReadConnectOptions(const ConnectionFlags& flags) {
  ConnectOptions options;
  options.tls = flags.tls || !flags.ca_file.empty() || !flags.cert_file.empty();
  options.server_name = flags.server_name;
  options.resolve_once = true;
  options.send_token_in_plain_text = flags.send_token_in_plain_text;
  for (const absl::Status& status :
       {ReadFile("--ca", flags.ca_file, options.authorities), ReadFile("--cert", flags.cert_file, options.certificate),
        ReadFile("--key", flags.key_file, options.private_key),
        ReadFile("--token-file", flags.token_file, options.token)}) {
    if (!status.ok()) return status;
  }
  if (absl::Status status = CheckPemFiles(flags, options); !status.ok()) return status;
  if (const char* token = std::getenv("CURV_TOKEN"); flags.token_file.empty() && token != nullptr) {
    options.token = token;
  }
  absl::StripAsciiWhitespace(&options.token);
  if (!flags.token_file.empty() && options.token.empty()) {
    return absl::InvalidArgumentError(absl::StrCat("--token-file: ", flags.token_file, " holds no token"));
  }
  if (!flags.token_file.empty() && HoldsHashes(options.token)) {
    return absl::InvalidArgumentError(
        absl::StrCat("--token-file: ", flags.token_file,
                     " holds hashes of tokens, which are for curvd --token-file: name the file with the token itself, "
                     "which curv token -o wrote"));
  }
  if (absl::Status status = CheckToken(options.token); !status.ok()) {
    const std::string source =
        flags.token_file.empty() ? "the variable CURV_TOKEN" : absl::StrCat("--token-file: ", flags.token_file);
    return absl::InvalidArgumentError(absl::StrCat(source, ": ", status.message()));
  }
  return options;
}

}  // namespace curv
