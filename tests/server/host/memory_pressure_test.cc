#include "server/host/memory_pressure.h"

#include <gtest/gtest.h>

#include <vector>

namespace curvd {
namespace {

using Level = MemoryPressure::Level;

constexpr uint64_t kPressureLimit = 256 << 20;

TEST(MemoryPressureTest, JudgesWhatTheProcessHasBesideTheLimit) {
  const MemoryPressure memory(kPressureLimit);
  EXPECT_EQ(memory.Judge(0), Level::kFine);
  EXPECT_EQ(memory.Judge(kPressureLimit + MemoryPressure::kHighBytes), Level::kFine);
  EXPECT_EQ(memory.Judge(kPressureLimit + MemoryPressure::kHighBytes + 1), Level::kHigh);
  EXPECT_EQ(memory.Judge(kPressureLimit + MemoryPressure::kCriticalBytes), Level::kHigh);
  EXPECT_EQ(memory.Judge(kPressureLimit + MemoryPressure::kCriticalBytes + 1), Level::kCritical);
}

TEST(MemoryPressureTest, HeadroomEndsWhereMemoryIsHigh) {
  const MemoryPressure memory(kPressureLimit);
  EXPECT_EQ(memory.Headroom(0), kPressureLimit + MemoryPressure::kHighBytes);
  EXPECT_EQ(memory.Headroom(kPressureLimit), MemoryPressure::kHighBytes);
  EXPECT_EQ(memory.Headroom(2 * kPressureLimit), 0u);
}

TEST(MemoryPressureTest, WhatCallsThatWaitShouldHoldIsNoPressure) {
  MemoryPressure memory(kPressureLimit);
  constexpr uint64_t kWaiting = 80 << 20;
  memory.Expect(kWaiting);
  EXPECT_EQ(memory.Judge(kPressureLimit + kWaiting + MemoryPressure::kHighBytes), Level::kFine);
  EXPECT_EQ(memory.Judge(kPressureLimit + kWaiting + MemoryPressure::kCriticalBytes + 1), Level::kCritical);
  EXPECT_EQ(memory.Headroom(kPressureLimit), kWaiting + MemoryPressure::kHighBytes);
  memory.Expect(0);
  EXPECT_EQ(memory.Judge(kPressureLimit + kWaiting), Level::kCritical);
}

TEST(MemoryPressureTest, TrimsOnceInAWhile) {
  MemoryPressure memory(kPressureLimit);
  const MemoryPressure::Clock::time_point start{std::chrono::hours(1)};
  EXPECT_TRUE(memory.Trim(start));
  EXPECT_FALSE(memory.Trim(start + MemoryPressure::kTrimInterval / 2));
  EXPECT_TRUE(memory.Trim(start + MemoryPressure::kTrimInterval));
}

TEST(MemoryPressureTest, KnowsWhatTheProcessHas) {
  const uint64_t before = ResidentBytes();
  EXPECT_GT(before, uint64_t{1} << 20);
  constexpr uint64_t kBytes = 64 << 20;
  std::vector<char> more(kBytes);
  volatile char* const written = more.data();  // so that no compiler leaves the pages out
  for (size_t i = 0; i < kBytes; i += 4096) written[i] = 1;
  EXPECT_GE(ResidentBytes() + (8 << 20), before + more.size());
}

}  // namespace
}  // namespace curvd
