// Finds the limits of the control groups that this process is in.
#pragma once

#include <string>
#include <vector>

namespace curvd {

// The directories that may hold this process's limits by `controller` ("memory", "cpu"): for each version of control
// groups from the outermost group that it can see (a container) to its own (a service of systemd). They need not exist.
// Files of version 1 and 2 have different names, so each may be looked for in all of them. `root` is where the file
// system begins, with a slash at its end.
std::vector<std::string> ControlGroupDirectories(const std::string& root, const std::string& controller);

// What a limit's file says; "" if there is none.
std::string ReadLimitFile(const std::string& path);

}  // namespace curvd
