#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "client/cli/command.h"
#include "client/cli/flags.h"
#include "client/cli/interrupt.h"
#include "client/cli/report/page_flags.h"
#include "client/report/page_server.h"

namespace curv {
namespace {

constexpr char kViewExamples[] =
    "Example:\n"
    "  curv view result.ply --quantity=gaussian\n"
    "Open the address that it prints in a browser of this machine; nobody else can guess it. Ctrl-C ends it, with "
    "exit\n"
    "code 0. curv report writes the same page into a file.";

struct ViewFlags {
  PageFlags page;
  uint64_t port = 0;
};

ExitCode Run(const ViewFlags& flags) {
  // Before anything is opened, so that an interrupt at any time ends the command well.
  InterruptWatch interrupt;
  MadePage page;
  if (const ExitCode code = MakePage(flags.page, page); code != ExitCode::kOk) return code;
  absl::StatusOr<PageServer> server = PageServer::Create(static_cast<uint16_t>(flags.port), std::move(page.html));
  if (!server.ok()) return Fail(ExitCode::kUsage, server.status());
  std::printf("%s\n", server->url().c_str());
  std::fflush(stdout);
  server->Serve(interrupt.token());
  return ExitCode::kOk;
}

}  // namespace

void AddView(CLI::App& app, Action& action) {
  auto flags = std::make_shared<ViewFlags>();
  CLI::App* command = app.add_subcommand("view", "Show a result in a browser of this machine, as curv report does");
  command->footer(absl::StrCat(kViewExamples, "\n", kExitCodesHelp));
  AddPageFlags(*command, flags->page);
  command->add_option("--port", flags->port, "port of 127.0.0.1 to listen on [a free one]")
      ->check(Whole(0, 65535))
      ->option_text("PORT");
  command->callback([flags, &action] { action = [flags] { return Run(*flags); }; });
}

}  // namespace curv
