#include "client/io/memory/machine_memory.h"

#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"

namespace curv {
namespace {

// Lowers `bytes` to the limit in a file, if there is one: "max", or a number beyond all memory, is none.
void TakeLimit(const std::string& path, uint64_t& bytes) {
  std::ifstream file(path);
  std::string text;
  uint64_t limit = 0;
  if (std::getline(file, text) && absl::SimpleAtoi(text, &limit) && limit > 0) bytes = std::min(bytes, limit);
}

// The same for the group `path` below `mount`, and for those around it.
void TakeLimits(const std::string& mount, const char* file, std::string path, uint64_t& bytes) {
  for (; path.size() > 1; path.resize(path.rfind('/'))) TakeLimit(absl::StrCat(mount, path, "/", file), bytes);
  TakeLimit(absl::StrCat(mount, "/", file), bytes);
}

}  // namespace

uint64_t UsableMemory(const std::string& root) {
  uint64_t bytes = static_cast<uint64_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
  const std::string mount = root + "sys/fs/cgroup";
  // Lines HIERARCHY:CONTROLLERS:PATH, controllers separated by commas; version 2 names none. A container may see its
  // own group where the mount begins, whatever the path says.
  std::string path_v1, path_v2;
  std::ifstream lines(root + "proc/self/cgroup");
  for (std::string line; std::getline(lines, line);) {
    const std::vector<std::string> fields = absl::StrSplit(line, absl::MaxSplits(':', 2));
    if (fields.size() != 3) continue;
    if (fields[1].empty()) path_v2 = fields[2];
    const std::vector<std::string> controllers = absl::StrSplit(fields[1], ',');
    if (std::find(controllers.begin(), controllers.end(), "memory") != controllers.end()) path_v1 = fields[2];
  }
  TakeLimits(mount, "memory.max", path_v2, bytes);
  TakeLimits(mount + "/memory", "memory.limit_in_bytes", path_v1, bytes);
  return bytes;
}

}  // namespace curv
