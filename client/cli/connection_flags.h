// The flags that say to which server a command's calls go, and how the caller proves who it is.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "client/connect_options.h"

namespace CLI {
class App;
}  // namespace CLI

namespace curv {

struct ConnectionFlags {
  std::string server;  // "HOST:PORT,..."; empty: a server in this process
  bool tls = false;
  std::string ca_file;
  std::string cert_file;
  std::string key_file;
  std::string server_name;
  std::string token_file;
  bool send_token_in_plain_text = false;
};

// Adds the flags to a command. Each of them but --server may come from the environment too, as CURV_TLS or
// CURV_TOKEN_FILE. `flags` must outlive `command`.
void AddConnectionFlags(CLI::App& command, ConnectionFlags& flags);

// INVALID_ARGUMENT, naming the flag, if there is no --server, and one was given that says how a server is reached. What
// the environment says is for commands with --server, and no error; nor is a flag whose variable is set as well.
absl::Status CheckNoneNeedsAServer(const ConnectionFlags& flags);

// Reads the files that the flags name, and returns the options that they ask for. The token comes from --token-file,
// else from the environment variable CURV_TOKEN, without blanks around it. INVALID_ARGUMENT, naming the flag, if a file
// cannot be read, holds no certificate or no key of it, or the token is empty.
absl::StatusOr<ConnectOptions> ReadConnectOptions(const ConnectionFlags& flags);

}  // namespace curv
