// Does the same to many files, one after the other, and goes on where it was interrupted.
#pragma once

#include <cstdint>
#include <functional>
#include <set>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/cli/command.h"
#include "client/cli/progress_bar.h"

namespace CLI {
class App;
}  // namespace CLI

namespace curv {

struct BatchFile {
  std::string input;
  std::string output;
};

// What became of one file.
struct BatchOutcome {
  ExitCode code = ExitCode::kOk;
  uint64_t points = 0;
  std::string summary{};  // of a file that is done; for people without the line's end
};

struct BatchOptions {
  std::string directory;  // for the outputs
  std::string options;    // what outputs depend on beside their input: OptionsText
  bool force = false;     // whether files that are finished are done again
  bool json = false;      // whether summaries are JSON lines
};

// Returns whether an output is a directory: one that is there, or a name that ends in "/".
bool IsDirectory(const std::string& output);

// Returns where each input's output goes: to its own name in the directory, with the extension of `format`, if that is
// not empty; without .gz; as PLY if its format cannot be written. INVALID_ARGUMENT if two inputs have the same name, an
// output would replace an input, or an input is standard input.
absl::StatusOr<std::vector<BatchFile>> PlanBatch(const std::vector<std::string>& inputs, const std::string& directory,
                                                 const std::string& format);

// Returns the options that were given on the command line, as "--k=30 --up=z", but for those of `leave_out`.
std::string OptionsText(const CLI::App& command, const std::set<std::string>& leave_out);

// Calls `process` for each file, with its share of the bytes of all that are not skipped, and tells on standard
// output what became of it, and at the end how many were done. A file is skipped whose output is newer than its input,
// and was finished with the same options, which the file .curv-finished.jsonl of the directory tells. The directory is
// made if it is not there. Files that fail do not stop the others; it ends early if no server can be reached, or if
// `stop` is requested. Returns kOk if every file is done or skipped, kFailed if some failed, the code that ended it
// early, or kOutput if the directory cannot be written.
ExitCode RunBatch(const std::vector<BatchFile>& files, const BatchOptions& options, const std::stop_token& stop,
                  const std::function<BatchOutcome(const BatchFile& file, const BatchShare& share)>& process);

}  // namespace curv
