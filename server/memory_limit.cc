#include "server/memory_limit.h"

#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <sstream>
#include <vector>

namespace curvd {
namespace {

std::string ReadFile(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

// The directories below `root` that hold the limits of group `path` and of the groups around it.
std::vector<std::string> GroupDirectories(const std::string& mount, std::string path) {
  std::vector<std::string> directories = {mount};
  for (; path.size() > 1; path.resize(path.rfind('/'))) directories.push_back(mount + path);
  return directories;
}

// Where limits on this process may stand, as /proc/self/cgroup tells: lines HIERARCHY:CONTROLLERS:PATH.
std::vector<std::string> LimitFiles(const std::string& root) {
  std::string path_v1, path_v2;
  std::istringstream lines(ReadFile(root + "proc/self/cgroup"));
  for (std::string line; std::getline(lines, line);) {
    const size_t path = line.find(':', line.find(':') + 1);
    if (path == std::string::npos) continue;
    if (line.compare(0, 3, "0::") == 0) path_v2 = line.substr(path + 1);
    if (line.find(":memory:") != std::string::npos) path_v1 = line.substr(path + 1);
  }
  std::vector<std::string> files;
  for (const std::string& directory : GroupDirectories(root + "sys/fs/cgroup", path_v2)) {
    files.push_back(directory + "/memory.max");
  }
  for (const std::string& directory : GroupDirectories(root + "sys/fs/cgroup/memory", path_v1)) {
    files.push_back(directory + "/memory.limit_in_bytes");
  }
  return files;
}

}  // namespace

std::optional<uint64_t> ParseControlGroupLimit(std::string_view text) {
  constexpr uint64_t kUnlimited = uint64_t{1} << 60;
  uint64_t bytes = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), bytes);
  if (error != std::errc() || bytes == 0 || bytes >= kUnlimited) return std::nullopt;
  return bytes;
}

uint64_t DetectMemoryBytes(const std::string& root) {
  uint64_t bytes = static_cast<uint64_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
  for (const std::string& file : LimitFiles(root)) {
    const std::optional<uint64_t> limit = ParseControlGroupLimit(ReadFile(file));
    if (limit.has_value()) bytes = std::min(bytes, *limit);
  }
  return bytes;
}

}  // namespace curvd
