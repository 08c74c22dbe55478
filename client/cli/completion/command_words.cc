#include "client/cli/completion/command_words.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "client/cli/result_columns.h"

namespace curv {
namespace {

// What --help calls a path.
constexpr std::array<std::string_view, 8> kFilePlaceholders = {"FILE",   "IN",  "IN...", "OUT",
                                                               "RESULT", "PNG", "HTML",  "DIR"};

// Up to the sentence or the list that goes into details.
std::string FirstClause(const std::string& help) {
  const size_t end = std::min({help.find(": "), help.find("; "), help.find(" ["), help.find('\n')});
  return help.substr(0, end);
}

// A check that compares with a set refuses what is not in it by "... not in {a,b}", which is the one way to ask CLI11
// for the set.
std::vector<std::string> MembersOf(CLI::Option& option) {
  constexpr std::string_view kRefusal = " not in {";
  for (int i = 0;; ++i) {
    const CLI::Validator* check = nullptr;
    try {
      check = option.get_validator(i);
    } catch (const CLI::OptionNotFound&) {
      return {};
    }
    std::string probe = "\x01";
    std::string refusal;
    try {
      refusal = (*check)(probe);
    } catch (const CLI::ValidationError&) {
      continue;  // refuses by an exception, as that for sizes in bytes does
    }
    const size_t begin = refusal.find(kRefusal);
    if (begin == std::string::npos || refusal.back() != '}') continue;
    const size_t first = begin + kRefusal.size();
    return absl::StrSplit(refusal.substr(first, refusal.size() - 1 - first), ',');
  }
}

// --quantity takes the name of any column as well, so that no check knows its words.
std::vector<std::string> ValuesOf(CLI::Option& option) {
  const std::vector<std::string>& names = option.get_lnames();
  if (std::find(names.begin(), names.end(), "quantity") == names.end()) return MembersOf(option);
  return absl::StrSplit(kQuantityWords, ", ");
}

ArgumentWords ArgumentWordsOf(CLI::Option& option) {
  ArgumentWords words;
  for (const std::string& name : option.get_snames()) words.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) words.names.push_back("--" + name);
  words.help = FirstClause(option.get_description());
  const std::string& text = option.get_option_text();
  words.placeholder = text.substr(0, text.find(' '));  // "COUNT [100]"
  words.takes_separate_value = option.get_items_expected_max() > 0 && !words.placeholder.empty();
  words.values = ValuesOf(option);
  words.is_list = option.get_delimiter() != '\0';
  words.is_file =
      std::find(kFilePlaceholders.begin(), kFilePlaceholders.end(), words.placeholder) != kFilePlaceholders.end();
  return words;
}

CommandWords CommandWordsOf(CLI::App& command, const std::string& name, const std::string& parent) {
  CommandWords words{.name = name,
                     .parent = parent,
                     .help = command.get_description(),
                     .subcommands = {},
                     .flags = {},
                     .positionals = {}};
  for (CLI::Option* option : command.get_options()) {
    if (option->get_group().empty()) continue;  // nor does the help have it
    (option->get_positional() ? words.positionals : words.flags).push_back(ArgumentWordsOf(*option));
  }
  return words;
}

void AddWordsOf(CLI::App& command, const std::string& name, const std::string& parent,
                std::vector<CommandWords>& commands) {
  const size_t own = commands.size();
  commands.push_back(CommandWordsOf(command, name, parent));
  for (CLI::App* subcommand : command.get_subcommands([](const CLI::App*) { return true; })) {
    const std::string& word = subcommand->get_name();
    commands[own].subcommands.push_back(word);
    AddWordsOf(*subcommand, name.empty() ? word : absl::StrCat(name, " ", word), name, commands);
  }
}

}  // namespace

std::vector<CommandWords> WordsOf(CLI::App& app) {
  std::vector<CommandWords> commands;
  AddWordsOf(app, "", "", commands);
  return commands;
}

}  // namespace curv
