#include "server/host/processor_limit.h"

#include <gtest/gtest.h>
#include <sched.h>

#include <filesystem>
#include <fstream>
#include <thread>

namespace curvd {
namespace {

TEST(ParseProcessorQuotaTest, RoundsUp) {
  EXPECT_EQ(ParseProcessorQuota("200000 100000\n"), std::optional<int>(2));
  EXPECT_EQ(ParseProcessorQuota("150000 100000\n"), std::optional<int>(2));
  EXPECT_EQ(ParseProcessorQuota("1000 100000\n"), std::optional<int>(1));
}

TEST(ParseProcessorQuotaTest, KnowsTheWordsForNoLimit) {
  for (const char* text : {"max 100000\n", "-1\n 100000\n", "", " ", "100000\n", "0 100000", "100000 0", "100000 -1"}) {
    EXPECT_EQ(ParseProcessorQuota(text), std::nullopt) << text;
  }
}

TEST(ParseProcessorQuotaTest, HoldsNumbersOfAnySize) {
  EXPECT_EQ(ParseProcessorQuota("9223372036854775807 1"), std::optional<int>(2147483647));
  EXPECT_EQ(ParseProcessorQuota("99999999999999999999 1"), std::nullopt);
}

TEST(DetectProcessorCountTest, CountsOnlyProcessorsThatItMayRunOn) {
  int count = 0;
  // On a thread of its own, whose affinity goes with it.
  std::thread([&count] {
    cpu_set_t usable;
    ASSERT_EQ(sched_getaffinity(0, sizeof(usable), &usable), 0);
    int first = 0;
    while (!CPU_ISSET(first, &usable)) ++first;
    CPU_ZERO(&usable);
    CPU_SET(first, &usable);
    ASSERT_EQ(sched_setaffinity(0, sizeof(usable), &usable), 0);
    count = DetectProcessorCount();
  }).join();
  EXPECT_EQ(count, 1);
}

TEST(DetectProcessorCountTest, TakesTheSmallerOfMachineAndControlGroup) {
  const std::string root = ::testing::TempDir() + "/curvd_processor_limit_test/";
  std::filesystem::create_directories(root + "sys/fs/cgroup");
  const int machine = DetectProcessorCount(root);
  EXPECT_GT(machine, 0);
  std::ofstream(root + "sys/fs/cgroup/cpu.max") << "50000 100000\n";
  EXPECT_EQ(DetectProcessorCount(root), 1);
  std::ofstream(root + "sys/fs/cgroup/cpu.max") << "1000000000 1000\n";
  EXPECT_EQ(DetectProcessorCount(root), machine);
  std::filesystem::remove_all(root);
}

// One quota at a time, so that each is seen to count.
TEST(DetectProcessorCountTest, TakesTheQuotaOfEachGroupAroundTheProcess) {
  const std::string root = ::testing::TempDir() + "/curvd_processor_groups_test/";
  const std::string v2 = root + "sys/fs/cgroup/system.slice/curvd.service/", v1 = root + "sys/fs/cgroup/cpu/a/b/";
  for (const std::string& directory : {v1, v2, root + "proc/self"}) std::filesystem::create_directories(directory);
  std::ofstream(root + "proc/self/cgroup") << "7:cpu,cpuacct:/a/b\n5:cpuset:/x\n0::/system.slice/curvd.service\n";
  const int machine = DetectProcessorCount(root);
  for (const std::string& group : {v2, v2 + "../", v2 + "../../"}) {
    std::ofstream(group + "cpu.max") << "100000 100000\n";
    EXPECT_EQ(DetectProcessorCount(root), 1) << group;
    std::ofstream(group + "cpu.max") << "max 100000\n";
    EXPECT_EQ(DetectProcessorCount(root), machine) << group;
  }
  for (const std::string& group : {v1, v1 + "../", v1 + "../../"}) {
    std::ofstream(group + "cpu.cfs_period_us") << "100000\n";
    std::ofstream(group + "cpu.cfs_quota_us") << "50000\n";
    EXPECT_EQ(DetectProcessorCount(root), 1) << group;
    std::ofstream(group + "cpu.cfs_quota_us") << "-1\n";
    EXPECT_EQ(DetectProcessorCount(root), machine) << group;
  }
  std::filesystem::remove_all(root);
}

}  // namespace
}  // namespace curvd
