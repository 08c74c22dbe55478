#include "server/observe/process_metrics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <prometheus/metric_family.h>
#include <prometheus/metric_type.h>
#include <unistd.h>

#include <chrono>
#include <map>
#include <string>

namespace curvd {
namespace {

using ::testing::UnorderedElementsAre;

std::map<std::string, double> Collect() {
  std::map<std::string, double> values;
  for (const prometheus::MetricFamily& family : ProcessMetrics().Collect()) {
    const prometheus::ClientMetric& metric = family.metric.at(0);
    values[family.name] = family.type == prometheus::MetricType::Counter ? metric.counter.value : metric.gauge.value;
  }
  return values;
}

TEST(ProcessMetricsTest, HasTheNamesOfOtherClientLibraries) {
  std::vector<std::string> names;
  for (const auto& [name, value] : Collect()) names.push_back(name);
  EXPECT_THAT(names, UnorderedElementsAre("process_cpu_seconds_total", "process_threads",
                                          "process_resident_memory_bytes", "process_virtual_memory_bytes",
                                          "process_start_time_seconds", "process_open_fds", "process_max_fds"));
}

TEST(ProcessMetricsTest, CountsDescriptors) {
  const double before = Collect()["process_open_fds"];
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  EXPECT_EQ(Collect()["process_open_fds"], before + 2);
  close(ends[0]);
  close(ends[1]);
  EXPECT_LT(before, Collect()["process_max_fds"]);
}

TEST(ProcessMetricsTest, TellsMemoryAndTimeInBaseUnits) {
  std::map<std::string, double> values = Collect();
  EXPECT_GT(values["process_resident_memory_bytes"], 1 << 20);
  EXPECT_LT(values["process_resident_memory_bytes"], values["process_virtual_memory_bytes"]);
  const double now = std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  // The system rounds the time of its own start to a second.
  EXPECT_LT(values["process_start_time_seconds"], now + 2.0);
  EXPECT_GT(values["process_start_time_seconds"], now - 3600.0);
  EXPECT_GE(values["process_threads"], 1.0);
}

}  // namespace
}  // namespace curvd
