#include "client/cli/files/format_flags.h"

#include <iterator>
#include <vector>

#include "CLI/CLI.hpp"

namespace curv {

void AddInputFormat(CLI::App& command, std::string& format) {
  command
      .add_option(
          "--format", format,
          "of - (standard input and output), and of files whose name does not tell it: ply, pcd, xyz, csv, las, "
          "npy, npz or, to read, obj")
      ->check(CLI::IsMember(std::vector<std::string>(std::begin(kFormats), std::end(kFormats))).description(""))
      ->option_text("NAME");
}

void AddFormatFlags(CLI::App& command, SaveOptions& options) {
  AddInputFormat(command, options.format);
  command.add_flag("--ascii", options.ascii, "write PLY and PCD as text");
}

std::FILE* SummaryStream(const std::string& output) { return output == "-" ? stderr : stdout; }

}  // namespace curv
