#include "client/io/memory/machine_memory.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/client/temp_dir.h"

namespace curv {
namespace {

void Write(const std::string& path, const std::string& text) {
  std::filesystem::create_directories(std::filesystem::path(path).parent_path());
  std::ofstream(path) << text;
}

TEST(UsableMemoryTest, IsTheLeastOfMachineAndControlGroups) {
  const TempDir dir;
  const std::string root = dir.File("root/");
  const uint64_t machine = UsableMemory(root);
  EXPECT_GT(machine, 0u);
  Write(root + "sys/fs/cgroup/memory.max", "max\n");
  EXPECT_EQ(UsableMemory(root), machine);
  Write(root + "sys/fs/cgroup/memory.max", "50000000\n");
  EXPECT_EQ(UsableMemory(root), 50'000'000u) << "a container sees its group where the mount begins";
  Write(root + "proc/self/cgroup", "3:cpu,memory:/pod/inner\n0::/slice/unit\n");
  Write(root + "sys/fs/cgroup/slice/unit/memory.max", "40000000\n");
  EXPECT_EQ(UsableMemory(root), 40'000'000u);
  Write(root + "sys/fs/cgroup/slice/memory.max", "30000000\n");
  EXPECT_EQ(UsableMemory(root), 30'000'000u) << "groups around it count, too";
  Write(root + "sys/fs/cgroup/memory/pod/memory.limit_in_bytes", "20000000\n");
  EXPECT_EQ(UsableMemory(root), 20'000'000u) << "version 1";
  Write(root + "sys/fs/cgroup/memory/pod/inner/memory.limit_in_bytes", "9223372036854771712\n");
  EXPECT_EQ(UsableMemory(root), 20'000'000u) << "what version 1 writes for no limit";
}

}  // namespace
}  // namespace curv
