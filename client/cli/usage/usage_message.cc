#include "client/cli/usage/usage_message.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "CLI/CLI.hpp"
#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "proto/nearest_word.h"

namespace curv {
namespace {

// The subcommand that the arguments name, or `app`.
const CLI::App& CommandOf(const CLI::App& app) {
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

// CLI11 says "--k: 1 required TEXT missing" of a flag at the end, or before another, that lacks its value.
std::string ParserText(const CLI::App& command, const CLI::ParseError& error) {
  constexpr char kMissing[] = " missing", kRequired[] = ": 1 required ";
  const std::string text = error.what();
  const size_t required = text.find(kRequired);
  if (required == std::string::npos || !absl::EndsWith(text, kMissing)) return text;
  const std::string flag = text.substr(0, required);
  const CLI::Option* option = command.get_option_no_throw(flag);
  const std::string help = option == nullptr ? "" : option->get_description();
  const std::string meaning = help.substr(0, help.find_first_of(";[("));
  return absl::StrCat(flag, ": its value is missing or empty", meaning.empty() ? "" : ": ",
                      absl::StripTrailingAsciiWhitespace(meaning));
}

}  // namespace

std::string UsageMessage(const CLI::App& app, const std::vector<std::string>& arguments, const CLI::ParseError& error) {
  const CLI::App& command = CommandOf(app);
  const std::vector<std::string> unexpected = Unexpected(app, arguments);
  return absl::StrCat(unexpected.empty() ? ParserText(command, error) : UnexpectedText(command, unexpected), "\nRun ",
                      FullName(command), " --help for what is possible.");
}

}  // namespace curv
