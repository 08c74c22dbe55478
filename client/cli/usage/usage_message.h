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
std::string UsageMessage(const CLI::App& app, const std::vector<std::string>& arguments, const CLI::ParseError& error);

}  // namespace curv
