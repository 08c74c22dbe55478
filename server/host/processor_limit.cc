#include "server/host/processor_limit.h"

#include <sched.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <sstream>
#include <thread>

#include "absl/strings/str_cat.h"
#include "server/host/control_groups.h"

namespace curvd {
namespace {

// std::thread::hardware_concurrency counts processors that are kept from this process, too.
int UsableProcessors() {
  cpu_set_t usable;
  if (sched_getaffinity(0, sizeof(usable), &usable) == 0) return std::max(1, CPU_COUNT(&usable));
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));  // more than a cpu_set_t holds
}

}  // namespace

std::optional<int> ParseProcessorQuota(std::string_view text) {
  int64_t quota = 0, period = 0;
  std::istringstream fields{std::string(text)};
  if (!(fields >> quota >> period) || quota <= 0 || period <= 0) return std::nullopt;
  const int64_t processors = quota / period + (quota % period == 0 ? 0 : 1);
  return static_cast<int>(std::min<int64_t>(processors, std::numeric_limits<int>::max()));
}

int DetectProcessorCount(const std::string& root) {
  int count = UsableProcessors();
  for (const std::string& directory : ControlGroupDirectories(root, "cpu")) {
    const std::string quota_v1 = absl::StrCat(ReadLimitFile(directory + "/cpu.cfs_quota_us"), " ",
                                              ReadLimitFile(directory + "/cpu.cfs_period_us"));
    for (const std::string& quota : {ReadLimitFile(directory + "/cpu.max"), quota_v1}) {
      count = std::min(count, ParseProcessorQuota(quota).value_or(count));
    }
  }
  return count;
}

}  // namespace curvd
