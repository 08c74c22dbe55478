// Declares what the subcommands of curv share: how they register, and how they end.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "absl/status/status.h"

namespace CLI {
class App;
}  // namespace CLI

namespace curv {

// How a run of curv ends. Documented in --help; never changed silently.
enum class ExitCode : int {
  kOk = 0,
  kFailed = 1,        // the server refused the cloud, or the estimate failed
  kUsage = 2,         // a flag is unknown or its value is out of range
  kInput = 3,         // the input file cannot be read or lacks what is needed
  kOutput = 4,        // the output file, or standard output, cannot be written; no file is left in part
  kUnavailable = 5,   // no server can be reached, or it is draining
  kTimedOut = 6,      // --timeout was over
  kInterrupted = 130  // SIGINT or SIGTERM
};

inline constexpr char kExitCodesHelp[] =
    "Exit codes: 0 done; 1 the server refused the cloud or the estimate failed; 2 wrong flags; 3 the input file "
    "cannot\n"
    "be read or lacks what is needed; 4 the output cannot be written (files are written whole or not at all);\n"
    "5 no server can be reached; 6 --timeout was over; 130 interrupted.";

// Runs a subcommand once the command line is parsed.
using Action = std::function<ExitCode()>;

// Each of these adds a subcommand. Parsing a command line that names it sets `action`, which must outlive `app`.
void AddEstimate(CLI::App& app, Action& action);
void AddTiles(CLI::App& app, Action& action);
void AddGenerate(CLI::App& app, Action& action);
void AddNormals(CLI::App& app, Action& action);
void AddOrient(CLI::App& app, Action& action);
void AddEvaluate(CLI::App& app, Action& action);
void AddRender(CLI::App& app, Action& action);
void AddSelect(CLI::App& app, Action& action);
void AddReport(CLI::App& app, Action& action);
void AddView(CLI::App& app, Action& action);
void AddInfo(CLI::App& app, Action& action);
void AddDoctor(CLI::App& app, Action& action);
void AddToken(CLI::App& app, Action& action);
// Completes all subcommands that `app` has when the command line is parsed.
void AddCompletion(CLI::App& app, Action& action);

// Text that may hold names of files, as a terminal may show it: control characters other than line feeds and tabs,
// which a terminal would obey, become \xNN.
std::string Visible(std::string_view text);

// The same as a word of a command line that a message proposes: in quotes where a shell would read it otherwise.
std::string ShellWord(std::string_view text);

// How messages name a file that is read or written: as Visible, and "-" in words.
std::string ShownInput(std::string_view path);
std::string ShownOutput(std::string_view path);

// What follows shows messages as Visible. Prints "curv: MESSAGE" on stderr and returns `code`.
ExitCode Fail(ExitCode code, const std::string& message);
ExitCode Fail(ExitCode code, const absl::Status& status);
// Prints an error that a server gave, or the way to it, and returns the code that follows from its status. `title`
// stands before the message. Errors of the way point to curv doctor.
ExitCode FailCall(const absl::Status& status, const std::string& title = "");
// Prints "curv: warning: MESSAGE" on stderr.
void PrintWarning(const std::string& message);
// Prints "curv: note: MESSAGE" on stderr.
void PrintNote(const std::string& message);

}  // namespace curv
