// curv: curvature of point clouds from the command line.
#include <cstdio>
#include <exception>
#include <iostream>
#include <new>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "about/version_line.h"
#include "client/cli/command.h"
#include "client/cli/flags.h"
#include "client/cli/usage/usage_message.h"

namespace {

int FailUsage(const std::string& message) { return static_cast<int>(curv::Fail(curv::ExitCode::kUsage, message)); }

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
  curv::RefuseValuesOfSwitches(app);
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked) {
    return app.exit(asked);  // --help, --version
  } catch (const CLI::ParseError& error) {
    return FailUsage(curv::UsageMessage(app, arguments, error));
  }
  if (const std::string message = curv::EmptyValueMessage(app, arguments); !message.empty()) return FailUsage(message);
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
