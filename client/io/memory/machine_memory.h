// How much memory this process may use.
#pragma once

#include <cstdint>
#include <string>

namespace curv {

// The least of the machine's memory and of the limits of the control groups, version 1 or 2, that this process is in:
// of a container, a service, and the groups around them. `root` is where the file system begins, with a slash at its
// end.
uint64_t UsableMemory(const std::string& root = "/");

}  // namespace curv
