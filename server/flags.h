// Reads curvd's command line, with the environment as fallback.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/server_options.h"

namespace curvd {

// What a command line asks for.
struct CommandLine {
  ServerOptions options;
  // Set by --help and --version: what to print on stdout instead of serving.
  std::string answer;
  // What the operator should know: variables that no flag reads.
  std::vector<std::string> warnings;
};

// Every flag --some-name may also be given as the environment variable CURVD_SOME_NAME; the command line wins. A flag
// or variable of a file that says who may call must not be empty. --version answers `version_line`. INVALID_ARGUMENT,
// naming flag, value and limit, if it cannot be understood or is out of range.
absl::StatusOr<CommandLine> ParseCommandLine(int argc, const char* const* argv, const std::string& version_line);

}  // namespace curvd
