#include "server/memory_limit.h"

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

}  // namespace
}  // namespace curvd
