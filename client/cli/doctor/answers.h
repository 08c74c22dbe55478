// Asks a server what it says about itself, and whether it lets this caller in.
#pragma once

#include <string>

#include "client/cli/doctor/examine.h"
#include "client/cli/doctor/findings.h"

namespace curv {

// Adds findings about version, caller, health, limits and clock, with `prefix` before what they say.
void AskWhatItSays(const std::string& target, const std::string& prefix, const ExamineOptions& options,
                   Findings& findings);

}  // namespace curv
