#include "core/base/page_pool.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cstring>
#include <fstream>
#include <thread>
#include <vector>

namespace curvd {
namespace {

constexpr size_t kMiB = size_t{1} << 20;
constexpr PagePool::Limits kMuch = {.kept = 1024 * kMiB, .together = 1024 * kMiB};

// Maps `bytes` bytes, writes them all, and gives them back.
void Use(PagePool& pool, size_t bytes) {
  void* pages = pool.Map(bytes);
  ASSERT_NE(pages, nullptr);
  std::memset(pages, 0xff, bytes);
  pool.Unmap(pages, bytes);
}

TEST(PagePoolTest, KeepsNothingUnlessTold) {
  PagePool pool;
  Use(pool, kMiB);
  EXPECT_EQ(pool.kept_bytes(), 0u);
}

TEST(PagePoolTest, HandsOutWhatItKeeps) {
  PagePool pool;
  pool.SetLimits(kMuch);
  void* pages = pool.Map(3 * kMiB);
  pool.Unmap(pages, 3 * kMiB);
  EXPECT_EQ(pool.kept_bytes(), 3 * kMiB);
  EXPECT_EQ(pool.Map(3 * kMiB), pages);
  EXPECT_EQ(pool.kept_bytes(), 0u);
  pool.Unmap(pages, 3 * kMiB);
}

TEST(PagePoolTest, NearlyEqualSizesFindEachOther) {
  PagePool pool;
  pool.SetLimits(kMuch);
  Use(pool, 24 * kMiB - 1000);
  const size_t kept = pool.kept_bytes();
  EXPECT_GE(kept, 24 * kMiB - 1000);
  EXPECT_LE(kept, 25 * kMiB);
  Use(pool, 24 * kMiB - 300'000);
  EXPECT_EQ(pool.kept_bytes(), kept);
  Use(pool, 20 * kMiB);
  EXPECT_GT(pool.kept_bytes(), kept);
}

TEST(PagePoolTest, RoundsUpByThreePercent) {
  PagePool pool;
  for (size_t bytes = 1; bytes < 200 * kMiB; bytes += bytes / 5 + 1) {
    pool.SetLimits(kMuch);
    Use(pool, bytes);
    EXPECT_GE(pool.kept_bytes(), bytes);
    EXPECT_LT(pool.kept_bytes(), bytes + bytes / 32 + 4096);
    pool.SetLimits({});
  }
}

TEST(PagePoolTest, GivesUpTheOldestOverItsLimit) {
  PagePool pool;
  pool.SetLimits({.kept = 10 * kMiB, .together = 1024 * kMiB});
  Use(pool, 4 * kMiB);
  Use(pool, 5 * kMiB);
  Use(pool, 3 * kMiB);
  EXPECT_EQ(pool.kept_bytes(), 8 * kMiB);  // without the first
  Use(pool, 11 * kMiB);                    // too large to be kept
  EXPECT_EQ(pool.kept_bytes(), 8 * kMiB);
}

TEST(PagePoolTest, FreshPagesAreZeroAndNeverKept) {
  PagePool pool;
  pool.SetLimits(kMuch);
  Use(pool, kMiB);
  auto* fresh = static_cast<char*>(pool.MapFresh(kMiB));
  for (size_t i = 0; i < kMiB; ++i) ASSERT_EQ(fresh[i], 0);
  pool.UnmapFresh(fresh, kMiB);
  EXPECT_EQ(pool.kept_bytes(), kMiB);
}

TEST(PagePoolTest, KeepsAFewHundredRanges) {
  PagePool pool;
  pool.SetLimits(kMuch);
  std::vector<void*> ranges(1000);
  for (void*& pages : ranges) pages = pool.Map(1);
  for (void* pages : ranges) pool.Unmap(pages, 1);
  EXPECT_GE(pool.kept_bytes(), 100 * 4096u);
  EXPECT_LE(pool.kept_bytes(), 500 * 4096u);
}

TEST(PagePoolTest, WhatIsInUseComesBeforeWhatIsKept) {
  PagePool pool;
  pool.SetLimits({.kept = 10 * kMiB, .together = 12 * kMiB});
  Use(pool, 4 * kMiB);
  Use(pool, 5 * kMiB);
  void* pages = pool.Map(7 * kMiB);
  EXPECT_EQ(pool.kept_bytes(), 5 * kMiB);
  void* more = pool.Map(6 * kMiB);
  EXPECT_EQ(pool.kept_bytes(), 0u);
  pool.Unmap(pages, 7 * kMiB);
  pool.Unmap(more, 6 * kMiB);
  EXPECT_EQ(pool.kept_bytes(), 6 * kMiB);
}

// Bytes that this process has mapped.
size_t MappedBytes() {
  size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * 4096;
}

TEST(PagePoolTest, LeavesMemoryToOthers) {
  PagePool pool;
  rlimit unlimited{};
  ASSERT_EQ(getrlimit(RLIMIT_AS, &unlimited), 0);
  const rlimit limit{.rlim_cur = MappedBytes() + PagePool::kLeftToOthers + 4 * kMiB, .rlim_max = unlimited.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_AS, &limit), 0);
  void* one = pool.Map(2 * kMiB);
  void* another = pool.Map(8 * kMiB);
  void* fresh = pool.MapFresh(8 * kMiB);
  const bool room_for_little = pool.HasRoomFor(kMiB), room_for_much = pool.HasRoomFor(8 * kMiB);
  ASSERT_EQ(setrlimit(RLIMIT_AS, &unlimited), 0);
  EXPECT_NE(one, nullptr);
  EXPECT_EQ(another, nullptr);
  EXPECT_EQ(fresh, nullptr);
  EXPECT_TRUE(room_for_little);
  EXPECT_FALSE(room_for_much);
  pool.Unmap(one, 2 * kMiB);
  Use(pool, 8 * kMiB);
}

TEST(PagePoolTest, ReleasesWhatNobodyUsed) {
  PagePool pool;
  pool.SetLimits(kMuch);
  Use(pool, kMiB);
  const auto between = PagePool::Clock::now();
  Use(pool, 2 * kMiB);
  pool.Release(between);
  EXPECT_EQ(pool.kept_bytes(), 2 * kMiB);
  pool.Release(PagePool::Clock::now() + std::chrono::seconds(1));
  EXPECT_EQ(pool.kept_bytes(), 0u);
}

TEST(PagePoolTest, AMemoryThatIsNotThereIsNoPage) {
  PagePool pool;
  EXPECT_EQ(pool.Map(size_t{1} << 60), nullptr);
  pool.SetLimits({.kept = kMiB, .together = kMiB});
  Use(pool, kMiB);
  EXPECT_EQ(pool.kept_bytes(), kMiB);  // what was not mapped is not in use
}

TEST(PagePoolTest, ThreadsNeverShareARange) {
  PagePool pool;
  pool.SetLimits({.kept = kMiB, .together = 2 * kMiB});
  std::vector<std::thread> threads;
  for (char mark = 1; mark <= 4; ++mark) {
    threads.emplace_back([&pool, mark] {
      for (size_t round = 1; round <= 300; ++round) {
        const size_t bytes = round % 7 * 30'000 + 1;
        auto* pages = static_cast<char*>(pool.Map(bytes));
        std::memset(pages, mark, bytes);
        std::this_thread::yield();
        for (size_t i = 0; i < bytes; i += 997) ASSERT_EQ(pages[i], mark);
        pool.Unmap(pages, bytes);
        if (round % 50 == 0) pool.Release(PagePool::Clock::now());
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
}

}  // namespace
}  // namespace curvd
