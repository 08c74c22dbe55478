#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "client/cli/completion/scripts.h"

namespace curv {
namespace {

// What is typed is taken apart: bash makes words of its own at the "=" of --flag=value.
constexpr char kBashHead[] = R"(# How bash completes a command line of curv; printed by `curv completion bash`.
_curv() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]}
  local command='' flag='' kind='' words='' prefix='' i
  if [[ $word == '=' ]]; then
    flag="$before=" word=''
  elif [[ $before == '=' && COMP_CWORD -gt 2 ]]; then
    flag="${COMP_WORDS[COMP_CWORD - 2]}="
  elif [[ $word == --*=* ]]; then
    flag="${word%%=*}=" prefix="${word%%=*}=" word=${word#*=}
  elif [[ $before == -* ]]; then
    flag=$before
  fi
  COMPREPLY=()
  for ((i = 1; i < COMP_CWORD; ++i)); do
    case "${command:+$command }${COMP_WORDS[i]}" in
)";

// One of the words, several of them with commas between, a file, or anything.
constexpr char kBashTail[] = R"(  esac
  if [[ -z $kind ]]; then
    # No flag that wants a value stands before.
    case "$command" in
)";

constexpr char kBashEnd[] = R"(    esac
    if [[ $word == -* ]]; then kind=one words=$flags; fi
  fi
  case $kind in
    file)
      compopt -o filenames 2>/dev/null
      mapfile -t COMPREPLY < <(compgen -f -- "$word")
      ;;
    list)
      if [[ $word == *,* ]]; then prefix=$prefix${word%,*}, word=${word##*,}; fi
      compopt -o nospace 2>/dev/null
      ;;&
    one | list) mapfile -t COMPREPLY < <(compgen -W "$words" -P "$prefix" -- "$word") ;;
  esac
}
complete -F _curv curv
)";

const char* KindOf(const ArgumentWords& argument) {
  if (!argument.values.empty()) return argument.is_list ? "list" : "one";
  return argument.is_file ? "file" : "any";
}

std::string Assignments(const ArgumentWords& argument) {
  return absl::StrCat("kind=", KindOf(argument), " words='", absl::StrJoin(argument.values, " "), "'");
}

void AddValueOfFlag(const std::string& command, const ArgumentWords& flag, std::string& script) {
  std::vector<std::string> patterns;
  for (const std::string& name : flag.names) {
    const bool has_value = flag.takes_separate_value || !flag.values.empty();
    if (flag.takes_separate_value) patterns.push_back(absl::StrCat("'", command, " ", name, "'"));
    if (has_value && name.starts_with("--")) patterns.push_back(absl::StrCat("'", command, " ", name, "='"));
  }
  if (patterns.empty()) return;
  absl::StrAppend(&script, "    ", absl::StrJoin(patterns, " | "), ") ", Assignments(flag), " ;;\n");
}

std::vector<std::string> FlagNames(const CommandWords& command) {
  std::vector<std::string> names;
  for (const ArgumentWords& flag : command.flags) names.insert(names.end(), flag.names.begin(), flag.names.end());
  return names;
}

// What may stand where no flag does.
std::string Words(const CommandWords& command) {
  if (!command.subcommands.empty())
    return absl::StrCat("kind=one words='", absl::StrJoin(command.subcommands, " "), "'");
  return command.positionals.empty() ? "kind=any" : Assignments(command.positionals.front());
}

}  // namespace

std::string BashScript(const std::vector<CommandWords>& commands) {
  std::vector<std::string> names;
  for (const CommandWords& command : commands) {
    if (!command.name.empty()) names.push_back(absl::StrCat("'", command.name, "'"));
  }
  std::string script = kBashHead;
  absl::StrAppend(&script, "      ", absl::StrJoin(names, " | "),
                  ") command=\"${command:+$command }${COMP_WORDS[i]}\" ;;\n",
                  "    esac\n  done\n  local flags=''\n  case \"$command $flag\" in\n");
  for (const CommandWords& command : commands) {
    for (const ArgumentWords& flag : command.flags) AddValueOfFlag(command.name, flag, script);
  }
  script += kBashTail;
  for (const CommandWords& command : commands) {
    absl::StrAppend(&script, "      '", command.name, "') ", Words(command), " flags='",
                    absl::StrJoin(FlagNames(command), " "), "' ;;\n");
  }
  return script + kBashEnd;
}

}  // namespace curv
