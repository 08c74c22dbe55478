#include "core/base/scratch_array.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cstdint>
#include <fstream>
#include <new>

namespace curvd {
namespace {

constexpr size_t kMiB = size_t{1} << 20;

TEST(ScratchArrayTest, KeepsWhatIsThereWhenItGrowsPastASmallBuffer) {
  ScratchArray<uint32_t> array;
  for (uint32_t i = 0; i < 100'000; ++i) {
    array.Reserve(i + 1);
    array[i] = i;
    ASSERT_EQ(reinterpret_cast<uintptr_t>(array.data()) % 64, 0u);
  }
  for (uint32_t i = 0; i < 100'000; ++i) ASSERT_EQ(array[i], i);
}

TEST(ScratchArrayTest, LargeBuffersLeaveMemoryToOthers) {
  size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  rlimit unlimited{};
  ASSERT_EQ(getrlimit(RLIMIT_AS, &unlimited), 0);
  const rlimit limit{.rlim_cur = pages * 4096 + PagePool::kLeftToOthers + 4 * kMiB, .rlim_max = unlimited.rlim_max};
  ScratchArray<char> array;
  array.Reserve(kMiB);
  array[7] = 'x';
  ASSERT_EQ(setrlimit(RLIMIT_AS, &limit), 0);
  bool failed = false;
  try {
    array.Reserve(8 * kMiB);  // the system has as much, but not beside what others need
  } catch (const std::bad_alloc&) {
    failed = true;
  }
  ASSERT_EQ(setrlimit(RLIMIT_AS, &unlimited), 0);
  EXPECT_TRUE(failed);
  EXPECT_EQ(array.capacity(), kMiB);
  EXPECT_EQ(array[7], 'x');
}

}  // namespace
}  // namespace curvd
