// Finds out how much memory this process may use.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace curvd {

// The number in a control group's limit file, or nullopt if it says that there is no limit ("max", or a number near
// 2^63 as version 1 writes it) or holds no number.
std::optional<uint64_t> ParseControlGroupLimit(std::string_view text);

// The smaller of the machine's memory and the limits of the control groups that this process is in, from its own (a
// service of systemd) to the outermost that it can see (a container). `root` is where the file system begins.
uint64_t DetectMemoryBytes(const std::string& root = "/");

}  // namespace curvd
