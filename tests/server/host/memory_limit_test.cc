#include "server/host/memory_limit.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace curvd {
namespace {

TEST(ParseControlGroupLimitTest, ReadsBytes) {
  EXPECT_EQ(ParseControlGroupLimit("536870912\n"), std::optional<uint64_t>(536870912));
}

TEST(ParseControlGroupLimitTest, KnowsTheWordsForNoLimit) {
  EXPECT_EQ(ParseControlGroupLimit("max\n"), std::nullopt);
  EXPECT_EQ(ParseControlGroupLimit("9223372036854771712\n"), std::nullopt);
  EXPECT_EQ(ParseControlGroupLimit(""), std::nullopt);
  EXPECT_EQ(ParseControlGroupLimit("0"), std::nullopt);
}

TEST(DetectMemoryBytesTest, TakesTheSmallerOfMachineAndControlGroup) {
  const std::string root = ::testing::TempDir() + "/curvd_memory_limit_test/";
  std::filesystem::create_directories(root + "sys/fs/cgroup");
  const uint64_t machine = DetectMemoryBytes(root);
  EXPECT_GT(machine, 0u);
  std::ofstream(root + "sys/fs/cgroup/memory.max") << "33554432\n";
  EXPECT_EQ(DetectMemoryBytes(root), 33554432u);
  std::ofstream(root + "sys/fs/cgroup/memory.max") << "max\n";
  EXPECT_EQ(DetectMemoryBytes(root), machine);
  std::filesystem::remove_all(root);
}

TEST(DetectMemoryBytesTest, TakesTheLimitOfEachGroupAroundTheProcess) {
  const std::string root = ::testing::TempDir() + "/curvd_memory_groups_test/";
  const std::string v2 = root + "sys/fs/cgroup/system.slice/curvd.service/", v1 = root + "sys/fs/cgroup/memory/a/b/";
  for (const std::string& directory : {v1, v2, root + "proc/self"}) std::filesystem::create_directories(directory);
  std::ofstream(root + "proc/self/cgroup") << "7:cpu,cpuacct:/x\n5:memory:/a/b\n0::/system.slice/curvd.service\n";
  std::ofstream(v2 + "memory.max") << "50331648\n";
  EXPECT_EQ(DetectMemoryBytes(root), 50331648u);
  std::ofstream(v2 + "../memory.max") << "41943040\n";
  EXPECT_EQ(DetectMemoryBytes(root), 41943040u);
  std::ofstream(v1 + "memory.limit_in_bytes") << "33554432\n";
  EXPECT_EQ(DetectMemoryBytes(root), 33554432u);
  std::filesystem::remove_all(root);
}

}  // namespace
}  // namespace curvd
