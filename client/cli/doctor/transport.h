// Finds out what is spoken at an address, and whether a certificate there is good.
#pragma once

#include <string>

#include "client/cli/doctor/examine.h"
#include "client/cli/doctor/findings.h"
#include "client/cli/doctor/socket.h"

namespace curv {

// Adds findings about protocol and certificate, with `prefix` before what they say. `host` is the name that was looked
// up. Returns whether a call has any chance.
bool LookAtTransport(const Address& address, const std::string& host, const std::string& prefix,
                     const ExamineOptions& options, Findings& findings);

}  // namespace curv
