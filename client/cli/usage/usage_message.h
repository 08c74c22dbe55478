// What curv says of a command line that it cannot parse.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace curv {

// The message for the arguments (without the program's name) whose parse by `app` threw `error`, and in a line of its
// own which --help lists what is possible. An argument that no flag and no file takes comes first, with the nearest
// name: that something is missing may follow from it.
std::string UsageMessage(CLI::App& app, const std::vector<std::string>& arguments, const CLI::ParseError& error);

// The message for the arguments, which `app` has parsed, if one of them is a flag that needs no value with an empty
// one, as --up= of a shell variable that is not set: CLI11 takes it for the flag alone. Otherwise "".
std::string EmptyValueMessage(CLI::App& app, const std::vector<std::string>& arguments);

}  // namespace curv
