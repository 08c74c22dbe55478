#include "core/index/select_nth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <tuple>
#include <vector>

#include "core/base/stop_sign.h"
#include "core/estimators/triangles/random_stream.h"

namespace curvd {
namespace {

// Records with `distinct` different coordinates, in random, ascending or organ-pipe order.
std::vector<PointRecord> MakeRecords(size_t count, int order, uint64_t distinct) {
  std::vector<PointRecord> records(count);
  RandomStream random(count, distinct);
  for (size_t i = 0; i < count; ++i) {
    const size_t key = order == 0 ? random.Next() : order == 1 ? i : std::min(i, count - i);
    records[i] = {{0.0f, static_cast<float>(key % distinct), 0.0f}, static_cast<int32_t>(i)};
  }
  return records;
}

TEST(SelectNthTest, SplitsLikeAFullSort) {
  const auto rank = [](const PointRecord& r) { return std::tuple(r.position[1], r.id); };
  for (size_t count : {1, 2, 16, 64, 1000, 30'000}) {
    for (int order = 0; order < 3; ++order) {
      for (uint64_t distinct : {1u, 5u, 1u << 20}) {
        for (size_t nth : {size_t{0}, count / 3, count / 2, count - 1, count}) {
          std::vector<PointRecord> records = MakeRecords(count, order, distinct), sorted = records;
          std::sort(sorted.begin(), sorted.end(), [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
          SelectNth(records.data(), records.data() + nth, records.data() + count, 1);
          for (size_t i = 0; i < count; ++i) {
            if (nth == count) break;
            ASSERT_EQ(rank(records[i]) < rank(sorted[nth]), i < nth) << count << " " << order << " " << distinct;
          }
        }
      }
    }
  }
}

bool IsSplit(const std::vector<PointRecord>& records, size_t nth) {
  const auto rank = [](const PointRecord& r) { return std::tuple(r.position[1], r.id); };
  const auto less = [&](const auto& a, const auto& b) { return rank(a) < rank(b); };
  const auto middle = records.begin() + static_cast<ptrdiff_t>(nth);
  return rank(*std::max_element(records.begin(), middle, less)) < rank(*std::min_element(middle, records.end(), less));
}

bool HoldsEachOnce(const std::vector<PointRecord>& records) {
  std::vector<bool> found(records.size());
  for (const PointRecord& record : records) found[record.id] = true;
  return std::count(found.begin(), found.end(), true) == static_cast<ptrdiff_t>(records.size());
}

// Ranges of more than 4 Mi records are partitioned slice by slice.
TEST(SelectNthTest, SlicesOfALargeRangeFitTogether) {
  const size_t count = 2 * kSlicedRecords + (size_t{1} << 20) + 12'345;
  for (const size_t nth : {count / 2, count / 50}) {
    std::vector<PointRecord> records = MakeRecords(count, 0, 1u << 20);
    SliceLog log;
    SelectNth(records.data(), records.data() + nth, records.data() + count, 1, StopSign(nullptr, &log));
    EXPECT_TRUE(IsSplit(records, nth));
    EXPECT_TRUE(HoldsEachOnce(records));
    EXPECT_EQ(log.largest, kSlicedRecords);
    EXPECT_LT(log.records, 3 * count);
  }
}

TEST(SelectNthTest, ASelectionEndsWithTheSliceAtWhichItIsStopped) {
  const size_t count = 2 * kSlicedRecords;
  std::vector<PointRecord> records = MakeRecords(count, 0, 1u << 20);
  const std::vector<PointRecord> before = records;
  SliceLog log{.stop_before = 1};
  SelectNth(records.data(), records.data() + count / 2, records.data() + count, 1, StopSign(nullptr, &log));
  EXPECT_EQ(log.slices, 2u);
  const auto same = [](const PointRecord& a, const PointRecord& b) { return a.id == b.id; };
  EXPECT_FALSE(std::equal(before.begin(), before.begin() + kSlicedRecords, records.begin(), same));
  EXPECT_TRUE(std::equal(before.begin() + kSlicedRecords, before.end(), records.begin() + kSlicedRecords, same));
}

// Whoever knows where samples are taken may put the least records there.
std::vector<PointRecord> RecordsThatMislead(size_t count) {
  std::vector<PointRecord> records = MakeRecords(count, 0, 1u << 20);
  for (PointRecord& record : records) record.position[1] += 1.0f;
  uint32_t weyl = 0x2545F491u;
  for (int i = 0; i < 512; ++i) {
    weyl += 0x9E3779B9u;
    records[(uint64_t{weyl} * count) >> 32].position[1] = i % 2 == 0 ? -1.0f : 0.0f;
  }
  return records;
}

TEST(SelectNthTest, ASampleThatMisleadsCostsAFewPasses) {
  const size_t count = 400'000;
  std::vector<PointRecord> records = RecordsThatMislead(count);
  SliceLog log;
  SelectNth(records.data(), records.data() + count / 2, records.data() + count, 1, StopSign(nullptr, &log));
  EXPECT_TRUE(IsSplit(records, count / 2));
  EXPECT_TRUE(HoldsEachOnce(records));
  EXPECT_LT(log.records, 6 * count);
  // The slice that follows the sample can be stopped as well.
  records = RecordsThatMislead(count);
  log = {.stop_before = 1};
  SelectNth(records.data(), records.data() + count / 2, records.data() + count, 1, StopSign(nullptr, &log));
  EXPECT_FALSE(IsSplit(records, count / 2));
}

TEST(SelectNthTest, AStoppedSelectionOnlyReorders) {
  const std::atomic<bool> stopped = true;
  std::vector<PointRecord> records = MakeRecords(30'000, 0, 1u << 20);
  SelectNth(records.data(), records.data() + 15'000, records.data() + records.size(), 1, StopSign(&stopped));
  EXPECT_TRUE(HoldsEachOnce(records));
}

// Records of a few coordinates, of which each sample holds the two that are least: the range of keys is halved until
// the others are told apart.
TEST(SelectNthTest, KeysTellRecordsApartWhateverTheirCoordinates) {
  const size_t count = 3 * kUnslicedRecords;
  for (const float low : {-0.0f, -3e38f, -1e-40f, 2.0f}) {
    for (const size_t nth : {count / 3, count - 2}) {
      std::vector<PointRecord> records = RecordsThatMislead(count);
      for (PointRecord& record : records) {
        if (record.position[1] <= 0.0f) record.position[1] = low;
        if (record.id % 2 == 0 && record.position[1] > 2.0f) record.position[1] = low < 0.0f ? 0.0f : 1e38f;
      }
      SelectNth(records.data(), records.data() + nth, records.data() + count, 1);
      EXPECT_TRUE(IsSplit(records, nth)) << low << " " << nth;
      EXPECT_TRUE(HoldsEachOnce(records));
    }
  }
}

}  // namespace
}  // namespace curvd
