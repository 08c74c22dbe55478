#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "client/cli/completion/scripts.h"

namespace curv {
namespace {

constexpr char kZshHead[] = R"(#compdef curv
# How zsh completes a command line of curv; printed by `curv completion zsh`.
_curv() {
  local context state state_descr line
  typeset -A opt_args
  _arguments -C )";

constexpr char kZshEnd[] = R"(      esac
      ;;
  esac
}
if [ "$funcstack[1]" = _curv ]; then
  _curv "$@"
else
  compdef _curv curv
fi
)";

std::string ZshQuoted(const std::string& text) {
  return absl::StrCat("'", absl::StrReplaceAll(text, {{"'", "'\\''"}}), "'");
}

// Within [...] or between colons of a specification.
std::string ZshEscaped(const std::string& text) {
  return absl::StrReplaceAll(text, {{"\\", "\\\\"}, {"[", "\\["}, {"]", "\\]"}, {":", "\\:"}});
}

// ":OUT:_files", ":NAME:(a b)"
std::string ValueOf(const ArgumentWords& argument) {
  std::string how = " ";
  if (argument.is_file) how = "_files";
  if (!argument.values.empty()) {
    const std::string values = absl::StrJoin(argument.values, " ");
    how = argument.is_list ? absl::StrCat("_sequence compadd - ", values) : absl::StrCat("(", values, ")");
  }
  return absl::StrCat(":", ZshEscaped(argument.placeholder.empty() ? "value" : argument.placeholder), ":", how);
}

// A specification of _arguments for each name of the flag; each makes the other names go away.
std::vector<std::string> FlagSpecifications(const ArgumentWords& flag) {
  std::vector<std::string> specifications;
  for (const std::string& name : flag.names) {
    const bool is_long = name.starts_with("--");
    std::string value;
    if (flag.takes_separate_value) value = ValueOf(flag);
    if (!flag.takes_separate_value && is_long && !flag.values.empty())
      value = absl::StrCat(":", ValueOf(flag));  // may be left out
    const char* joint = value.empty() ? "" : flag.takes_separate_value ? (is_long ? "=" : "+") : "=-";
    specifications.push_back(ZshQuoted(
        absl::StrCat("(", absl::StrJoin(flag.names, " "), ")", name, joint, "[", ZshEscaped(flag.help), "]", value)));
  }
  return specifications;
}

std::vector<std::string> FlagSpecificationsOf(const CommandWords& command) {
  std::vector<std::string> specifications;
  for (const ArgumentWords& flag : command.flags) {
    for (std::string& specification : FlagSpecifications(flag)) specifications.push_back(std::move(specification));
  }
  return specifications;
}

std::vector<std::string> SpecificationsOf(const CommandWords& command) {
  std::vector<std::string> specifications = FlagSpecificationsOf(command);
  if (!command.subcommands.empty()) {
    specifications.push_back(ZshQuoted(absl::StrCat("1:command:(", absl::StrJoin(command.subcommands, " "), ")")));
  }
  for (const ArgumentWords& positional : command.positionals) {
    specifications.push_back(ZshQuoted(absl::StrCat("*", ValueOf(positional))));
  }
  return specifications;
}

}  // namespace

std::string ZshScript(const std::vector<CommandWords>& commands) {
  std::string script = kZshHead;
  absl::StrAppend(
      &script, absl::StrJoin(FlagSpecificationsOf(commands.front()), " "),
      " '1:command:->command' '*::argument:->argument'\n  case $state in\n    command)\n      local -a commands=(\n");
  for (const CommandWords& command : commands) {
    if (!command.name.empty() && command.parent.empty()) {
      absl::StrAppend(&script, "        ", ZshQuoted(absl::StrCat(command.name, ":", ZshEscaped(command.help))), "\n");
    }
  }
  absl::StrAppend(&script,
                  "      )\n      _describe command commands\n      ;;\n    argument)\n      local name=$words[1]\n");
  // Of a command within another, the second word is the command.
  for (const CommandWords& command : commands) {
    if (command.name.empty() || command.subcommands.empty()) continue;
    absl::StrAppend(&script, "      if [[ $name == ", command.name,
                    " ]] && (( CURRENT > 2 )); then\n        shift words\n        (( --CURRENT ))\n",
                    "        name=\"$name $words[1]\"\n      fi\n");
  }
  script += "      case $name in\n";
  for (const CommandWords& command : commands) {
    if (command.name.empty()) continue;
    absl::StrAppend(&script, "        '", command.name, "')\n          _arguments -s \\\n            ",
                    absl::StrJoin(SpecificationsOf(command), " \\\n            "), "\n          ;;\n");
  }
  return script + kZshEnd;
}

}  // namespace curv
