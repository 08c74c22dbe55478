// What can be typed after "curv", read from CLI11's own tree of commands and flags.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}  // namespace CLI

namespace curv {

// A flag or a positional argument.
struct ArgumentWords {
  std::vector<std::string> names;  // "-o", "--output"; none of a positional argument
  std::string help;                // one line, up to where details begin
  std::string placeholder;         // what --help calls the value, "OUT"; empty of a flag without a value
  // A flag may go without its value, which then stands behind "=" alone.
  bool takes_separate_value = false;
  // What the value may be, as far as that is known: one of these, of which several stand with commas between if
  // `is_list`; or the path of a file. Any text, if neither.
  std::vector<std::string> values;
  bool is_list = false;
  bool is_file = false;
};

struct CommandWords {
  std::string name;    // "tiles plan" of a command within another
  std::string parent;  // the name of that other
  std::string help;
  std::vector<std::string> subcommands;  // the last words of their names
  std::vector<ArgumentWords> flags;
  std::vector<ArgumentWords> positionals;
};

// Those of each subcommand, and of theirs, in the order of --help; the first, of no name, is `app` itself.
std::vector<CommandWords> WordsOf(CLI::App& app);

}  // namespace curv
