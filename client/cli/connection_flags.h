// The flags that say where a command's calls go, and what they show of who makes them.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "client/connect_options.h"

namespace CLI {
class App;
}  // namespace CLI

namespace curv {

struct ConnectionFlags {
  std::string server;  // "": in this process
  bool tls = false;
  std::string ca_file;
  std::string cert_file;
  std::string key_file;
  std::string server_name;
  std::string token_file;
  bool send_token_in_plain_text = false;
};

// Each flag but --server may come from the environment too, as CURV_TLS or CURV_TOKEN_FILE. `flags` must outlive
// `command`.
void AddConnectionFlags(CLI::App& command, ConnectionFlags& flags);

// What the flags ask for, files read. The token comes from --token-file, else from the environment variable CURV_TOKEN,
// without blanks around it. INVALID_ARGUMENT, naming the flag, if a file cannot be read or the token is empty.
absl::StatusOr<ConnectOptions> ReadConnectOptions(const ConnectionFlags& flags);

}  // namespace curv
