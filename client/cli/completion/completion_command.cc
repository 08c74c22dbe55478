#include <cstdio>
#include <memory>
#include <string>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "client/cli/command.h"
#include "client/cli/completion/scripts.h"

namespace curv {
namespace {

constexpr char kCompletionExamples[] =
    "In this shell alone:\n"
    "  source <(curv completion bash)           or zsh, after compinit\n"
    "  curv completion fish | source\n"
    "In each that starts from now on:\n"
    "  curv completion bash > ~/.local/share/bash-completion/completions/curv\n"
    "  curv completion zsh > DIRECTORY/_curv    for a directory of $fpath\n"
    "  curv completion fish > ~/.config/fish/completions/curv.fish";

std::string ScriptOf(const std::string& shell, CLI::App& app) {
  const std::vector<CommandWords> commands = WordsOf(app);
  if (shell == "bash") return BashScript(commands);
  return shell == "zsh" ? ZshScript(commands) : FishScript(commands);
}

}  // namespace

void AddCompletion(CLI::App& app, Action& action) {
  auto shell = std::make_shared<std::string>();
  CLI::App* command =
      app.add_subcommand("completion", "Print a script by which a shell completes curv's command lines");
  command->footer(absl::StrCat(kCompletionExamples, "\n", kExitCodesHelp));
  command->add_option("shell", *shell, "bash, zsh or fish")
      ->required()
      ->check(CLI::IsMember({"bash", "zsh", "fish"}).description(""))
      ->option_text("SHELL");
  command->callback([shell, &app, &action] {
    action = [shell, &app] {
      std::fputs(ScriptOf(*shell, app).c_str(), stdout);
      return ExitCode::kOk;
    };
  });
}

}  // namespace curv
