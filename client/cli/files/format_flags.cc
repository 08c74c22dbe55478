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
  command.add_flag("--ascii", options.ascii, "write PLY and PCD as text; LAS, NPY and NPZ have no such form");
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

CLI::Option* AddOutput(CLI::App& command, std::string& output, const std::string& help) {
  const auto name_standard_output = [](std::string& path) {
    if (path == "/dev/stdout" || path == "/dev/fd/1" || path == "/proc/self/fd/1") path = "-";
    return std::string();
  };
  return command.add_option("-o,--output", output, help)
      ->transform(CLI::Validator(name_standard_output, ""))
      ->required()
      ->option_text("OUT");
}

std::FILE* SummaryStream(const std::string& output) { return output == "-" ? stderr : stdout; }

}  // namespace curv
