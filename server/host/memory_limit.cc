#include "server/host/memory_limit.h"

#include <unistd.h>

#include <algorithm>
#include <charconv>

#include "server/host/control_groups.h"

namespace curvd {

std::optional<uint64_t> ParseControlGroupLimit(std::string_view text) {
  constexpr uint64_t kUnlimited = uint64_t{1} << 60;
  uint64_t bytes = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), bytes);
  if (error != std::errc() || bytes == 0 || bytes >= kUnlimited) return std::nullopt;
  return bytes;
}

uint64_t DetectMemoryBytes(const std::string& root) {
  uint64_t bytes = static_cast<uint64_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
  for (const std::string& directory : ControlGroupDirectories(root, "memory")) {
    for (const char* file : {"/memory.max", "/memory.limit_in_bytes"}) {
      const std::optional<uint64_t> limit = ParseControlGroupLimit(ReadLimitFile(directory + file));
      if (limit.has_value()) bytes = std::min(bytes, *limit);
    }
  }
  return bytes;
}

}  // namespace curvd
