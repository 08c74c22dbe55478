#include "server/host/control_groups.h"

#include <fstream>
#include <sstream>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"

namespace curvd {
namespace {

// Adds the directories below `mount` of group `path` and of the groups around it.
void AddGroups(const std::string& mount, std::string path, std::vector<std::string>& directories) {
  directories.push_back(mount);
  for (; path.size() > 1; path.resize(path.rfind('/'))) directories.push_back(mount + path);
}

}  // namespace

std::vector<std::string> ControlGroupDirectories(const std::string& root, const std::string& controller) {
  // /proc/self/cgroup has lines HIERARCHY:CONTROLLERS:PATH, controllers separated by commas; version 2 names none.
  const std::string wanted = absl::StrCat(",", controller, ",");
  std::string path_v1, path_v2;
  std::istringstream lines(ReadLimitFile(root + "proc/self/cgroup"));
  for (std::string line; std::getline(lines, line);) {
    const size_t controllers = line.find(':');
    const size_t path = line.find(':', controllers + 1);
    if (path == std::string::npos) continue;
    if (absl::StartsWith(line, "0::")) path_v2 = line.substr(path + 1);
    const std::string names = line.substr(controllers + 1, path - controllers - 1);
    if (absl::StrContains(absl::StrCat(",", names, ","), wanted)) path_v1 = line.substr(path + 1);
  }
  std::vector<std::string> directories;
  AddGroups(root + "sys/fs/cgroup", path_v2, directories);
  AddGroups(absl::StrCat(root, "sys/fs/cgroup/", controller), path_v1, directories);
  return directories;
}

std::string ReadLimitFile(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

}  // namespace curvd
