#include "client/cli/files/format_flags.h"

#include "CLI/CLI.hpp"

namespace curv {

void AddFormatFlags(CLI::App& command, SaveOptions& options) {
  command.add_flag("--ascii", options.ascii, "write PLY and PCD as text");
}

}  // namespace curv
