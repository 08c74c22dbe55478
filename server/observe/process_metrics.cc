#include "server/observe/process_metrics.h"

#include <dirent.h>
#include <sys/resource.h>
#include <unistd.h>

#include <fstream>
#include <optional>
#include <sstream>
#include <string>

#include "server/observe/scrape_builder.h"

namespace curvd {
namespace {

// Of proc(5), /proc/PID/stat.
struct ProcessStat {
  double user_ticks = 0, system_ticks = 0, threads = 0, start_ticks = 0, virtual_bytes = 0, resident_pages = 0;
};

std::optional<ProcessStat> ReadStat() {
  std::ifstream file("/proc/self/stat");
  std::string text;
  std::getline(file, text);
  // The second field, the name in parentheses, may hold anything; the third follows the last parenthesis.
  const size_t name_end = text.rfind(')');
  if (name_end == std::string::npos) return std::nullopt;
  std::istringstream fields(text.substr(name_end + 1));
  const auto skip = [&fields](int count) {
    std::string field;
    while (count-- > 0) fields >> field;
  };
  ProcessStat stat;
  skip(11);  // state to cmajflt
  fields >> stat.user_ticks >> stat.system_ticks;
  skip(4);  // cutime to nice
  fields >> stat.threads;
  skip(1);  // itrealvalue
  fields >> stat.start_ticks >> stat.virtual_bytes >> stat.resident_pages;
  if (!fields) return std::nullopt;
  return stat;
}

// Unix time of the machine's start.
std::optional<double> BootSeconds() {
  std::ifstream file("/proc/stat");
  for (std::string word; file >> word;) {
    double seconds = 0;
    if (word == "btime" && file >> seconds) return seconds;
  }
  return std::nullopt;
}

std::optional<double> OpenDescriptors() {
  DIR* folder = opendir("/proc/self/fd");
  if (folder == nullptr) return std::nullopt;
  int count = 0;
  while (readdir(folder) != nullptr) ++count;
  closedir(folder);
  return count - 3;  // ".", ".." and the folder itself
}

void AddStat(const ProcessStat& stat, ScrapeBuilder& scrape) {
  const auto ticks_per_second = static_cast<double>(sysconf(_SC_CLK_TCK));
  const auto page_bytes = static_cast<double>(sysconf(_SC_PAGESIZE));
  scrape.AddCounter("process_cpu_seconds_total", "CPU time spent, in user and system mode.",
                    (stat.user_ticks + stat.system_ticks) / ticks_per_second);
  scrape.AddGauge("process_threads", "Threads of the process.", stat.threads);
  scrape.AddGauge("process_resident_memory_bytes", "Bytes of memory in use.", stat.resident_pages * page_bytes);
  scrape.AddGauge("process_virtual_memory_bytes", "Bytes of address space.", stat.virtual_bytes);
  if (const std::optional<double> boot = BootSeconds()) {
    scrape.AddGauge("process_start_time_seconds", "Unix time of the process's start.",
                    *boot + stat.start_ticks / ticks_per_second);
  }
}

}  // namespace

std::vector<prometheus::MetricFamily> ProcessMetrics::Collect() const {
  ScrapeBuilder scrape;
  if (const std::optional<ProcessStat> stat = ReadStat()) AddStat(*stat, scrape);
  if (const std::optional<double> open = OpenDescriptors()) {
    scrape.AddGauge("process_open_fds", "Open file descriptors, sockets included.", *open);
  }
  rlimit limit = {};
  if (getrlimit(RLIMIT_NOFILE, &limit) == 0) {
    scrape.AddGauge("process_max_fds", "File descriptors that may be open.", static_cast<double>(limit.rlim_cur));
  }
  return scrape.TakeFamilies();
}

}  // namespace curvd
