#include "core/index/select_nth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <tuple>
#include <vector>

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

// Ranges of more than 4 Mi records are partitioned slice by slice.
TEST(SelectNthTest, SlicesOfALargeRangeFitTogether) {
  const size_t count = (size_t{9} << 20) + 12'345;
  for (const size_t nth : {count / 2, count / 50}) {
    std::vector<PointRecord> records = MakeRecords(count, 0, 1u << 20);
    SelectNth(records.data(), records.data() + nth, records.data() + count, 1);
    const auto rank = [](const PointRecord& r) { return std::tuple(r.position[1], r.id); };
    const auto less = [&](const auto& a, const auto& b) { return rank(a) < rank(b); };
    const auto largest = std::max_element(records.begin(), records.begin() + nth, less);
    const auto smallest = std::min_element(records.begin() + nth, records.end(), less);
    EXPECT_LT(rank(*largest), rank(*smallest));
    std::vector<bool> found(count);
    for (const PointRecord& record : records) found[record.id] = true;
    EXPECT_EQ(std::count(found.begin(), found.end(), true), count);
  }
}

TEST(SelectNthTest, ACancelledSelectionOnlyReorders) {
  const std::atomic<bool> cancelled = true;
  std::vector<PointRecord> records = MakeRecords(30'000, 0, 1u << 20);
  SelectNth(records.data(), records.data() + 15'000, records.data() + records.size(), 1, &cancelled);
  std::vector<bool> found(records.size());
  for (const PointRecord& record : records) found[record.id] = true;
  EXPECT_EQ(std::count(found.begin(), found.end(), true), records.size());
}

}  // namespace
}  // namespace curvd
