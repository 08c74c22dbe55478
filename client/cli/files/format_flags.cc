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
  command
      .add_option_function<std::string>(
          "--names",
          [&options](const std::string& name) {
            options.names = name == "cloudcompare" ? PlyNames::kCloudCompare
                            : name == "meshlab"    ? PlyNames::kMeshLab
                                                   : PlyNames::kOwn;
          },
          "what properties of PLY are called: as columns are (own, the default), scalar_NAME, which is all that "
          "CloudCompare keeps (cloudcompare), or the mean curvature quality, as MeshLab calls its one scalar (meshlab)")
      ->check(CLI::IsMember({"own", "cloudcompare", "meshlab"}).description(""))
      ->option_text("PROGRAM");
}

std::FILE* SummaryStream(const std::string& output) { return output == "-" ? stderr : stdout; }

}  // namespace curv
