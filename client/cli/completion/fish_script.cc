#include <algorithm>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "client/cli/completion/scripts.h"

namespace curv {
namespace {

std::string FishQuoted(const std::string& text) {
  return absl::StrCat("'", absl::StrReplaceAll(text, {{"\\", "\\\\"}, {"'", "\\'"}}), "'");
}

// Where the words hold: within a command, before one of its own subcommands.
std::string Condition(const CommandWords& command) {
  if (command.name.empty()) return "__fish_use_subcommand";
  const std::string seen = "__fish_seen_subcommand_from ";
  std::string condition = absl::StrCat(seen, absl::StrReplaceAll(command.name, {{" ", "; and " + seen}}));
  if (!command.subcommands.empty())
    absl::StrAppend(&condition, "; and not ", seen, absl::StrJoin(command.subcommands, " "));
  return condition;
}

std::string Line(const CommandWords& command, const std::string& rest, const std::string& help) {
  return absl::StrCat("complete -c curv -n ", FishQuoted(Condition(command)), rest, " -d ", FishQuoted(help), "\n");
}

// "(__curv_list a b)" makes lists of them, with commas between.
std::string Candidates(const ArgumentWords& argument) {
  const std::string values = absl::StrJoin(argument.values, " ");
  return FishQuoted(argument.is_list ? absl::StrCat("(__curv_list ", values, ")") : values);
}

std::string FlagLine(const CommandWords& command, const ArgumentWords& flag) {
  std::string rest;
  for (const std::string& name : flag.names) {
    const bool is_long = name.starts_with("--");
    absl::StrAppend(&rest, is_long ? " -l " : " -s ", name.substr(is_long ? 2 : 1));
  }
  if (!flag.takes_separate_value) return Line(command, rest, flag.help);
  if (flag.is_file) return Line(command, rest + " -r -F", flag.help);
  return Line(command, rest + " -x" + (flag.values.empty() ? "" : " -a " + Candidates(flag)), flag.help);
}

std::string PositionalLine(const CommandWords& command, const ArgumentWords& positional) {
  if (positional.is_file) return Line(command, " -F", positional.help);
  if (positional.values.empty()) return "";
  return Line(command, " -a " + Candidates(positional), positional.help);
}

}  // namespace

std::string FishScript(const std::vector<CommandWords>& commands) {
  std::string script =
      "# How fish completes a command line of curv; printed by `curv completion fish`.\n"
      "function __curv_list\n"
      "    set -l typed (string replace -r '^--[a-z-]+=' '' -- (commandline -ct))\n"
      "    set -l before (string replace -r '[^,]*$' '' -- $typed)\n"
      "    for word in $argv\n"
      "        echo $before$word\n"
      "    end\n"
      "end\n"
      "complete -c curv -f\n";
  for (const CommandWords& command : commands) {
    if (command.name.empty()) continue;
    const auto parent = std::find_if(commands.begin(), commands.end(),
                                     [&](const CommandWords& other) { return other.name == command.parent; });
    script +=
        Line(*parent, " -a " + command.name.substr(parent->name.empty() ? 0 : parent->name.size() + 1), command.help);
  }
  for (const CommandWords& command : commands) {
    for (const ArgumentWords& flag : command.flags) script += FlagLine(command, flag);
    for (const ArgumentWords& positional : command.positionals) script += PositionalLine(command, positional);
  }
  return script;
}

}  // namespace curv
