#include "client/cli/usage/usage_message.h"

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "CLI/CLI.hpp"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "proto/nearest_word.h"

namespace curv {
namespace {

// The subcommand that the arguments name, or `app`.
CLI::App& CommandOf(CLI::App& app) {
  const std::vector<CLI::App*> named = app.get_subcommands();
  return named.empty() ? app : CommandOf(*named.front());
}

// "curv tiles plan".
std::string FullName(const CLI::App& command) {
  const CLI::App* parent = command.get_parent();
  return parent == nullptr ? command.get_name() : absl::StrCat(FullName(*parent), " ", command.get_name());
}

// All names of flags, with their dashes.
std::vector<std::string> FlagNames(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

std::vector<std::string> CommandNames(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::App* subcommand : command.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(subcommand->get_name());
  }
  return names;
}

// What no flag and no file takes, in the order in which it was typed.
std::vector<std::string> Unexpected(const CLI::App& app, const std::vector<std::string>& arguments) {
  std::vector<std::string> left = app.remaining(/*recurse=*/true);
  std::erase(left, "--");  // the mark between flags and files is no argument
  std::vector<std::string> ordered;
  for (const std::string& argument : arguments) {
    const auto found = std::find(left.begin(), left.end(), argument);
    if (found == left.end()) continue;
    ordered.push_back(argument);
    left.erase(found);
  }
  ordered.insert(ordered.end(), left.begin(), left.end());
  return ordered;
}

std::string UnexpectedText(const CLI::App& command, const std::vector<std::string>& unexpected) {
  const std::string& first = unexpected.front();
  const std::vector<std::string> commands = CommandNames(command);
  if (!commands.empty() && !absl::StartsWith(first, "-")) {
    return absl::StrCat("there is no command ", first,
                        command.get_parent() == nullptr ? "" : " of " + FullName(command),
                        curvd::DidYouMean(first, commands));
  }
  const std::string text =
      absl::StrCat(unexpected.size() == 1 ? "this argument was not expected: " : "these arguments were not expected: ",
                   absl::StrJoin(unexpected, " "));
  if (!absl::StartsWith(first, "-")) return text;
  std::error_code ignored;
  if (std::filesystem::exists(first, ignored)) return absl::StrCat(text, ": the file of that name is ./", first);
  return absl::StrCat(text, curvd::DidYouMean(first.substr(0, first.find('=')), FlagNames(command)));
}

// "it must be text or json" of a flag whose one value is one of a few words; "" of any other.
std::string WordsText(CLI::Option& option) {
  if (option.get_delimiter() != '\0') return "";
  std::string refusal;
  try {
    refusal = (*option.get_validator(0))(std::string());
  } catch (const CLI::OptionNotFound&) {  // takes any value
  }
  constexpr std::string_view kBefore = " not in {";  // what CLI::IsMember says
  if (!refusal.starts_with(kBefore)) return "";
  const std::string words = refusal.substr(kBefore.size(), refusal.size() - kBefore.size() - 1);
  const size_t last = words.rfind(',');
  if (last == std::string::npos) return absl::StrCat("it must be ", words);
  return absl::StrCat("it must be ", absl::StrReplaceAll(words.substr(0, last), {{",", ", "}}), " or ",
                      words.substr(last + 1));
}

std::string EmptyText(CLI::App& command, const std::string& flag, const char* problem) {
  CLI::Option* option = command.get_option_no_throw(flag);
  std::string meaning = option == nullptr ? "" : WordsText(*option);
  if (option != nullptr && meaning.empty()) meaning = option->get_description();
  return absl::StrCat(flag, problem, meaning.empty() ? "" : ": ", meaning);
}

// Says what CLI11 says of the number of a flag's values in words that tell what to do: "--k: 1 required TEXT missing"
// of a flag at the end, or before another, that lacks its value, and "--k: At Most 1 required but received 2".
std::string ParserText(CLI::App& command, const CLI::ParseError& error) {
  constexpr char kMissing[] = " missing", kRequired[] = ": 1 required ";
  constexpr char kTooOften[] = ": At Most 1 required but received ";
  const std::string text = error.what();
  if (const size_t too_often = text.find(kTooOften); too_often != std::string::npos) {
    return absl::StrCat(text.substr(0, too_often), ": is given ", text.substr(too_often + sizeof(kTooOften) - 1),
                        " times: give it once");
  }
  const size_t required = text.find(kRequired);
  if (required == std::string::npos || !absl::EndsWith(text, kMissing)) return text;
  return EmptyText(command, text.substr(0, required), ": its value is missing or empty");
}

std::string WithHint(const std::string& text, const CLI::App& command) {
  return absl::StrCat(text, "\nRun ", FullName(command), " --help for what is possible.");
}

}  // namespace

std::string UsageMessage(CLI::App& app, const std::vector<std::string>& arguments, const CLI::ParseError& error) {
  CLI::App& command = CommandOf(app);
  const std::vector<std::string> unexpected = Unexpected(app, arguments);
  if (!unexpected.empty()) return WithHint(UnexpectedText(command, unexpected), command);
  // What the error says may follow from it.
  const std::string empty = EmptyValueMessage(app, arguments);
  return empty.empty() ? WithHint(ParserText(command, error), command) : empty;
}

std::string EmptyValueMessage(CLI::App& app, const std::vector<std::string>& arguments) {
  CLI::App& command = CommandOf(app);
  for (const std::string& argument : arguments) {
    if (argument == "--") break;  // files follow
    if (!absl::StartsWith(argument, "--") || argument.find('=') != argument.size() - 1) continue;
    const std::string flag = argument.substr(0, argument.size() - 1);
    const CLI::Option* option = command.get_option_no_throw(flag);
    if (option == nullptr || option->get_items_expected_max() > 0) continue;  // CLI11 refuses those
    return WithHint(EmptyText(command, flag, ": its value is empty"), command);
  }
  return "";
}

}  // namespace curv
