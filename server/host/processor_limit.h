// Finds out how many processors this process may use.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace curvd {

// The processors that a quota "QUOTA PERIOD" of CPU time is worth, as version 2 of control groups writes it, rounded
// up: 150000 microseconds every 100000 are 2. At least 1. nullopt if it says that there is no limit ("max", or -1 as
// version 1 writes it) or is no quota.
std::optional<int> ParseProcessorQuota(std::string_view text);

// The smallest of the processors that this process may run on (a cpuset, an affinity) and of the quotas of the control
// groups that it is in, from its own (a service of systemd) to the outermost that it can see (a container). At least 1.
// `root` is where the file system begins.
int DetectProcessorCount(const std::string& root = "/");

}  // namespace curvd
