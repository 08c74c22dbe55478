// Writes scripts by which shells complete a command line of curv.
#pragma once

#include <string>
#include <vector>

#include "client/cli/completion/command_words.h"

namespace curv {

// Of bash 4.1 or later, without the package bash-completion; zsh 5; fish 3. The first of `commands` is curv itself.
std::string BashScript(const std::vector<CommandWords>& commands);
std::string ZshScript(const std::vector<CommandWords>& commands);
std::string FishScript(const std::vector<CommandWords>& commands);

}  // namespace curv
