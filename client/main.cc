// curv: curvature of point clouds from the command line.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <iostream>
#include <new>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "CLI/CLI.hpp"
#include "about/version_line.h"
#include "absl/strings/str_cat.h"
#include "client/cli/command.h"

namespace {

// What to say of arguments that no flag and no file takes. One that is mistyped is often missed elsewhere: that a flag
// is missing, which the parser finds first, would hide it. None, if all arguments have a place.
std::optional<std::string> UnexpectedArguments(const CLI::App& app) {
  std::vector<std::string> unexpected = app.remaining(/*recurse=*/true);
  std::erase(unexpected, "--");  // the mark between flags and files is no argument
  if (unexpected.empty()) return std::nullopt;
  std::error_code ignored;
  const bool is_file = unexpected[0].starts_with('-') && std::filesystem::exists(unexpected[0], ignored);
  return absl::StrCat(CLI::ExtrasError("curv", unexpected).what(),
                      is_file ? absl::StrCat(": the file of that name is ./", unexpected[0]) : "");
}

int Run(int argc, char** argv) {
  CLI::App app("curv estimates the curvature of point clouds, and their normals, with a curvd server.", "curv");
  app.set_version_flag("--version", curvd::VersionLine("curv"), "Print version and commit, and exit");
  app.footer(curv::kExitCodesHelp);
  app.require_subcommand(0, 1);
  curv::Action action;
  curv::AddEstimate(app, action);
  curv::AddTiles(app, action);
  curv::AddGenerate(app, action);
  curv::AddNormals(app, action);
  curv::AddOrient(app, action);
  curv::AddEvaluate(app, action);
  curv::AddRender(app, action);
  curv::AddSelect(app, action);
  curv::AddReport(app, action);
  curv::AddView(app, action);
  curv::AddInfo(app, action);
  curv::AddDoctor(app, action);
  curv::AddToken(app, action);
  curv::AddCompletion(app, action);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked) {
    return app.exit(asked);  // --help, --version
  } catch (const CLI::ParseError& error) {
    const std::string message = UnexpectedArguments(app).value_or(error.what());
    std::fprintf(stderr, "curv: %s\nRun with --help for what is possible.\n", curv::Visible(message).c_str());
    return static_cast<int>(curv::ExitCode::kUsage);
  }
  if (action == nullptr) {
    std::fprintf(stderr, "curv: a subcommand is needed\n\n%s", app.help().c_str());
    return static_cast<int>(curv::ExitCode::kUsage);
  }
  return static_cast<int>(action());
}

// What was printed may not have arrived, on a full disk for instance: a run without another fault has failed then.
int Flushed(int exit_code) {
  std::cout.flush();
  const bool has_arrived = std::cout.good() && std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
  if (has_arrived || exit_code != static_cast<int>(curv::ExitCode::kOk)) return exit_code;
  std::fputs("curv: standard output cannot be written\n", stderr);
  return static_cast<int>(curv::ExitCode::kOutput);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return Flushed(Run(argc, argv));
  } catch (const std::bad_alloc&) {
    std::fputs("curv: out of memory\n", stderr);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "curv: %s\n", error.what());
  }
  return static_cast<int>(curv::ExitCode::kFailed);
}
