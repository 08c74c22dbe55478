#include <cstdio>
#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "client/cli/command.h"
#include "client/cli/flags.h"
#include "client/cli/numbers.h"
#include "client/cli/table_vectors.h"
#include "client/io/oriented_cloud.h"
#include "client/io/table_file.h"

namespace curv {
namespace {

constexpr char kOrientExamples[] =
    "Example:\n"
    "  curv orient scan.ply -o oriented.ply\n"
    "Normals that were estimated point by point know the surface's direction but not its side. This command negates\n"
    "some of them so that neighbors agree: outward on closed surfaces, to the side of the majority on open ones. All\n"
    "other columns stay as they are. curv estimate --orient does the same on the way.";

struct OrientFlags {
  std::string input;
  std::string output;
};

ExitCode Run(const OrientFlags& flags) {
  if (absl::Status status = CheckWritable(flags.output); !status.ok()) return Fail(ExitCode::kOutput, status);
  absl::StatusOr<PointTable> table = LoadTable(flags.input);
  if (!table.ok()) return Fail(ExitCode::kInput, table.status());
  for (const std::string& note : table->notes) PrintNote(absl::StrCat(flags.input, ": ", note));
  if (absl::Status status = ExtractCloud(*table).status(); !status.ok()) {
    return Fail(ExitCode::kInput, absl::StrCat(flags.input, ": ", status.message()));
  }
  const size_t flipped = OrientTable(*table, /*threads=*/0);
  if (absl::Status status = SaveTable(*table, flags.output); !status.ok()) return Fail(ExitCode::kOutput, status);
  std::printf("%s: negated %s of %s normals\n", flags.output.c_str(), WithCommas(flipped).c_str(),
              WithCommas(table->size()).c_str());
  return ExitCode::kOk;
}

}  // namespace

void AddOrient(CLI::App& app, Action& action) {
  auto flags = std::make_shared<OrientFlags>();
  CLI::App* command = app.add_subcommand("orient", "Make the normals of a cloud point to one side of its surface");
  command->footer(absl::StrCat(kOrientExamples, "\n", kExitCodesHelp));
  command->add_option("input", flags->input, absl::StrCat("the cloud: ", kReadableExtensions))
      ->required()
      ->option_text("IN");
  command->add_option("-o,--output", flags->output, absl::StrCat("the cloud: ", kWritableExtensions))
      ->required()
      ->option_text("OUT");
  command->callback([flags, &action] { action = [flags] { return Run(*flags); }; });
}

}  // namespace curv
