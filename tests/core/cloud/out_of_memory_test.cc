// What becomes of a cloud when the n-th allocation finds no memory, for every n.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "core/cloud/cloud.h"
#include "tests/core/failing_new.h"

namespace curvd::testing {
namespace {

// Points that are spread along a line, every eleventh of them invalid, every third one halo.
template <typename Scalar>
struct Points {
  explicit Points(size_t size) {
    for (size_t i = 0; i < size; ++i) {
      for (const size_t scalar : {i, i % 7, size_t{1}}) positions.push_back(static_cast<Scalar>(scalar));
      for (const int scalar : {0, 0, i % 11 == 0 ? 0 : 1}) normals.push_back(static_cast<Scalar>(scalar));
      ids.push_back(5 + 2 * i);
      roles.push_back(i % 3 == 0 ? PointRole::kHalo : PointRole::kQuery);
    }
  }
  size_t size() const { return ids.size(); }

  // Points [first, last).
  absl::Status AppendTo(Cloud& cloud, size_t first, size_t last, bool is_part) const {
    const auto bytes = [&](const std::vector<Scalar>& scalars) {
      return std::string_view(reinterpret_cast<const char*>(&scalars[3 * first]), 3 * (last - first) * sizeof(Scalar));
    };
    if (!is_part) return cloud.Append(bytes(positions), bytes(normals));
    const size_t count = last - first;
    return cloud.AppendPart(bytes(positions), bytes(normals), std::span(ids).subspan(first, count),
                            std::span(roles).subspan(first, count));
  }

  std::vector<Scalar> positions, normals;
  std::vector<uint64_t> ids;
  std::vector<PointRole> roles;
};

// The cloud of these points, which is given them again from where it had no memory for them.
template <typename Scalar>
Cloud Collect(const Points<Scalar>& points, bool is_part) {
  constexpr size_t kChunk = 700;
  Cloud cloud(sizeof(Scalar) == 4 ? ScalarType::kFloat32 : ScalarType::kFloat64, InvalidPointPolicy::kSkip);
  while (cloud.size() < points.size()) {
    const size_t first = cloud.size(), last = std::min(first + kChunk, points.size());
    const absl::Status status = points.AppendTo(cloud, first, last, is_part);
    EXPECT_TRUE(status.ok() || KindOf(status) == ErrorKind::kOutOfMemory) << status;
    EXPECT_EQ(cloud.point_set().size(), cloud.size());
  }
  while (true) {
    const absl::Status status = cloud.Finish();
    if (status.ok()) return cloud;
    EXPECT_EQ(KindOf(status), ErrorKind::kOutOfMemory) << status;
  }
}

void ExpectSame(const Cloud& a, const Cloud& b) {
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(a.invalid_count(), b.invalid_count());
  EXPECT_EQ(a.invalid_query_count(), b.invalid_query_count());
  EXPECT_EQ(a.point_set().query_count(), b.point_set().query_count());
  for (size_t i = 0; i < a.size(); ++i) {
    const auto rank = static_cast<int32_t>(i);
    ASSERT_EQ(a.point_set().seed_of(rank), b.point_set().seed_of(rank));
    ASSERT_EQ(a.point_set().is_query(rank), b.point_set().is_query(rank));
    // Invalid points are NaN in either.
    if (i % 11 == 0) continue;
    ASSERT_EQ(a.position(i), b.position(i));
  }
}

template <typename Scalar>
void FailEachAllocation(size_t size) {
  const Points<Scalar> points(size);
  for (const bool is_part : {false, true}) {
    const Cloud whole = Collect(points, is_part);
    EXPECT_EQ(whole.invalid_count(), (size + 10) / 11);
    for (size_t first = 0;; ++first) {
      FailingNew failure(first, FailingNew::Failing::kOne);
      const Cloud cloud = Collect(points, is_part);
      failure.Stop();
      ExpectSame(cloud, whole);
      if (!failure.has_failed()) break;
      ASSERT_LT(first, 1000u);
    }
  }
}

TEST(CloudOutOfMemoryTest, FloatsGoOnWhereThereWasNoMemory) {
  FailEachAllocation<float>(Cloud::kBlockPoints + 10'000);  // a second slab
}

TEST(CloudOutOfMemoryTest, DoublesGoOnWhereThereWasNoMemory) { FailEachAllocation<double>(3'000); }

}  // namespace
}  // namespace curvd::testing
