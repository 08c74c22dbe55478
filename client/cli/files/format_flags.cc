#include "client/cli/files/format_flags.h"

#include <iterator>
#include <utility>
#include <vector>

#include "CLI/CLI.hpp"

namespace curv {

namespace {

CLI::Option* NameAFormat(CLI::Option* flag, const char* without = "") {
  std::vector<std::string> formats(std::begin(kFormats), std::end(kFormats));
  std::erase(formats, without);
  return flag->check(CLI::IsMember(std::move(formats)).description(""))->option_text("NAME");
}

constexpr char kFormatHelp[] =
    "of - (standard input and output), and of files whose name does not tell it: ply, pcd, xyz, csv, las, "
    "npy, npz or, to read, obj";

// How a format is written.
void AddFormFlags(CLI::App& command, SaveOptions& options) {
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

}  // namespace

void AddInputFormat(CLI::App& command, std::string& format) {
  NameAFormat(command.add_option("--format", format, kFormatHelp));
}

void AddFormats(CLI::App& command, std::string& input_format, SaveOptions& options) {
  // Flags take effect in the order in which they are added: those of one end win, wherever they stand.
  NameAFormat(command.add_option_function<std::string>(
      "--format", [&](const std::string& name) { input_format = options.format = name; }, kFormatHelp));
  NameAFormat(command.add_option("--input-format", input_format, "the same of what is read alone"));
  NameAFormat(command.add_option("--output-format", options.format, "the same of what is written alone"), "obj");
  AddFormFlags(command, options);
}

void AddOutputFormat(CLI::App& command, SaveOptions& options) {
  AddInputFormat(command, options.format);
  AddFormFlags(command, options);
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
