#include "core/cloud/point_set.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <latch>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/cloud/cloud.h"
#include "core/job/estimation_job.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

TEST(PointSetTest, QueriesAloneTakeNoMemory) {
  PointSet set;
  set.AddQueries(1'000'000);
  set.Add(1'000'000, PointRole::kQuery);
  EXPECT_EQ(set.bytes(), 0u);
  EXPECT_EQ(set.query_count(), 1'000'001u);
  EXPECT_TRUE(set.is_query(77));
  EXPECT_EQ(set.seed_of(77), 77u);
  EXPECT_EQ(set.slot_of(77), 77u);
}

TEST(PointSetTest, SlotsCountTheQueries) {
  PointSet set;
  set.AddQueries(2);
  set.Add(2, PointRole::kHalo);
  set.Add(3, PointRole::kQuery);
  EXPECT_EQ(set.query_count(), 3u);
  EXPECT_FALSE(set.is_query(2));
  EXPECT_EQ(set.slot_of(1), 1u);
  EXPECT_EQ(set.slot_of(3), 2u);
  EXPECT_FALSE(set.has_ids());
}

TEST(PointSetTest, IdsNeedNotBeDense) {
  PointSet set;
  set.AddQueries(1);
  set.Add(uint64_t{1} << 40, PointRole::kQuery);
  EXPECT_EQ(set.seed_of(0), 0u);
  EXPECT_EQ(set.seed_of(1), uint64_t{1} << 40);
  EXPECT_EQ(set.slot_of(1), 1u);
  const PointSet moved = std::move(set);
  EXPECT_EQ(moved.seed_of(1), uint64_t{1} << 40);
}

template <typename T>
std::string_view Bytes(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

// `points` with the ids `first_id`, `first_id` + 1, ...; the roles are all queries where `roles` is empty.
Cloud PartOf(const TestPoints& points, uint64_t first_id, const std::vector<PointRole>& roles) {
  std::vector<uint64_t> ids(points.size());
  for (size_t i = 0; i < ids.size(); ++i) ids[i] = first_id + i;
  Cloud cloud(ScalarType::kFloat32, InvalidPointPolicy::kSkip);
  cloud.Expect(points.size());
  EXPECT_TRUE(cloud.AppendPart(Bytes(points.positions), Bytes(points.normals), ids, roles).ok());
  EXPECT_TRUE(cloud.Finish().ok());
  return cloud;
}

bool SameValues(const PointCurvature& a, const PointCurvature& b) {
  return a.status == b.status && a.mean == b.mean && a.gaussian == b.gaussian && a.k1 == b.k1 && a.k2 == b.k2 &&
         a.d1 == b.d1 && a.d2 == b.d2 && a.radius == b.radius;
}

TEST(PointSetTest, HaloPointsChangeNoByteOfAQuery) {
  const TestPoints points = Sphere(6'000, 1.0);
  std::vector<PointRole> roles;
  for (size_t i = 0; i < points.size(); ++i) roles.push_back(i % 3 == 0 ? PointRole::kQuery : PointRole::kHalo);
  for (const std::string_view estimator : kEstimators) {
    EstimatorOptions options;
    options.estimator = estimator;
    const EstimationResult whole = MustEstimate(points.ToCloud(), options);
    const EstimationResult part = MustEstimate(PartOf(points, 0, roles), options);
    ASSERT_EQ(part.field.points.size(), 2'000u);
    EXPECT_EQ(part.field.status_counts[static_cast<size_t>(PointStatus::kOk)], 2'000u);
    for (size_t i = 0; i < 2'000; ++i) {
      ASSERT_TRUE(SameValues(part.field.points[i], whole.field.points[3 * i]))
          << "estimator " << estimator << ", query " << i;
    }
  }
}

TEST(PointSetTest, IdsSeedTheRandomStrategies) {
  const TestPoints points = Sphere(2'000, 1.0);
  for (const std::string_view estimator : kEstimators) {
    EstimatorOptions options;
    options.estimator = estimator;
    const bool is_random = estimator == "uniform" || estimator == "independent";
    const EstimationResult whole = MustEstimate(points.ToCloud(), options);
    const EstimationResult same = MustEstimate(PartOf(points, 0, {}), options);
    const EstimationResult other = MustEstimate(PartOf(points, uint64_t{1} << 40, {}), options);
    for (size_t i = 0; i < points.size(); ++i) {
      ASSERT_TRUE(SameValues(same.field.points[i], whole.field.points[i]));
      ASSERT_EQ(SameValues(other.field.points[i], whole.field.points[i]), !is_random) << estimator;
    }
  }
}

// `points` with ids that descend: the first point has the last rank.
Cloud Reversed(const TestPoints& points) {
  std::vector<uint64_t> ids;
  for (size_t i = 0; i < points.size(); ++i) ids.push_back(points.size() - i);
  Cloud cloud;
  EXPECT_TRUE(cloud.AppendPart(Bytes(points.positions), Bytes(points.normals), ids, {}).ok());
  EXPECT_TRUE(cloud.Finish().ok());
  return cloud;
}

TEST(PointSetTest, RefusalsNamePlacesAndNotRanks) {
  constexpr size_t kDense = 200;
  TestPoints points = Sphere(1'000, 1.0);
  for (size_t i = 0; i < kDense; ++i) {
    for (float& coordinate : points.positions[i]) coordinate *= 1e-3f;
  }
  EstimatorOptions options;
  options.neighborhood = NeighborRadius{0.01};
  options.max_neighbor_count = 100;
  WorkerPool pool(1);
  const absl::Status dense = EstimateCurvature(Reversed(points), options, pool).status();
  ASSERT_EQ(KindOf(dense), ErrorKind::kNeighborhoodTooLarge) << dense;
  EXPECT_LT(std::stoul(SubjectOf(dense).point), kDense) << dense;

  TestPoints flipped = Sphere(5'000, 1.0);
  for (float& component : flipped.normals[100]) component = -component;
  EstimatorOptions strict;
  strict.opposed_normals = OpposedNormalsPolicy::kReject;
  const absl::Status opposed = EstimateCurvature(Reversed(flipped), strict, pool).status();
  ASSERT_EQ(KindOf(opposed), ErrorKind::kOpposedNormals) << opposed;
  EXPECT_EQ(opposed, EstimateCurvature(flipped.ToCloud(), strict, pool).status());
}

TEST(PointSetTest, OnlyQueriesAreCounted) {
  TestPoints points = Sphere(1'000, 1.0);
  points.normals[0] = points.normals[1] = points.normals[2] = {0, 0, 0};
  std::vector<PointRole> roles(1'000, PointRole::kQuery);
  roles[1] = roles[7] = PointRole::kHalo;
  const EstimationResult result = MustEstimate(PartOf(points, 5, roles), {});
  ASSERT_EQ(result.field.points.size(), 998u);
  EXPECT_EQ(result.field.points[0].status, PointStatus::kInvalidInput);
  EXPECT_EQ(result.field.points[1].status, PointStatus::kInvalidInput);
  EXPECT_EQ(result.field.points[2].status, PointStatus::kOk);
  EXPECT_EQ(result.field.status_counts[static_cast<size_t>(PointStatus::kInvalidInput)], 2u);
  EXPECT_EQ(result.field.status_counts[static_cast<size_t>(PointStatus::kOk)], 996u);
}

TEST(PointSetTest, ProgressCountsQueriesAlone) {
  const TestPoints points = Sphere(6'000, 1.0);
  std::vector<PointRole> roles;
  for (size_t i = 0; i < points.size(); ++i) roles.push_back(i % 3 == 0 ? PointRole::kQuery : PointRole::kHalo);
  WorkerPool pool(2);
  std::latch done(1);
  const auto job = EstimationJob::Start(PartOf(points, 0, roles), {}, pool, JobPriority::kBatch,
                                        [&](const absl::StatusOr<EstimationResult>& result) {
                                          EXPECT_TRUE(result.ok());
                                          done.count_down();
                                        });
  done.wait();
  EXPECT_EQ(job->progress().points_estimated, 2'000u);
}

TEST(CloudTest, RanksPointsByTheirIds) {
  const TestPoints points = Sphere(3, 1.0);
  Cloud cloud;
  ASSERT_TRUE(cloud
                  .AppendPart(Bytes(points.positions), Bytes(points.normals), std::vector<uint64_t>{9, 1, 5},
                              std::vector<PointRole>{PointRole::kQuery, PointRole::kHalo, PointRole::kQuery})
                  .ok());
  ASSERT_TRUE(cloud.Finish().ok());
  ASSERT_TRUE(cloud.Rank().ok());
  EXPECT_EQ(cloud.record(0).id, 2);
  EXPECT_EQ(cloud.record(1).id, 0);
  EXPECT_EQ(cloud.record(2).id, 1);
  const PointSet set = cloud.TakePointSet();
  EXPECT_EQ(set.seed_of(0), 1u);
  EXPECT_EQ(set.seed_of(2), 9u);
  EXPECT_EQ(set.place_of(0), 1u);
  EXPECT_FALSE(set.is_query(0));
  EXPECT_EQ(set.slot_of(1), 1u);
  EXPECT_EQ(set.slot_of(2), 0u);
}

TEST(CloudTest, RanksIdsOfAllSizes) {
  const TestPoints points = Sphere(1'000, 1.0);
  std::vector<uint64_t> ids;
  for (uint64_t i = 0; i < points.size(); ++i) ids.push_back(i * 0x9E3779B97F4A7C15u);
  Cloud cloud;
  ASSERT_TRUE(cloud.AppendPart(Bytes(points.positions), Bytes(points.normals), ids).ok());
  ASSERT_TRUE(cloud.Finish().ok());
  ASSERT_TRUE(cloud.Rank().ok());
  const PointSet set = cloud.TakePointSet();
  std::vector<uint64_t> sorted = ids;
  std::sort(sorted.begin(), sorted.end());
  for (int32_t rank = 0; rank < 1'000; ++rank) {
    ASSERT_EQ(set.seed_of(rank), sorted[static_cast<size_t>(rank)]);
    ASSERT_EQ(ids[set.place_of(rank)], set.seed_of(rank));
  }
}

TEST(CloudTest, RefusesTwoPointsOfOneId) {
  const TestPoints points = Sphere(3, 1.0);
  for (const std::vector<uint64_t>& ids :
       {std::vector<uint64_t>{3, 3, 4}, {3, 2, 3}, {~uint64_t{0}, 1, ~uint64_t{0}}}) {
    Cloud cloud;
    ASSERT_TRUE(cloud.AppendPart(Bytes(points.positions), Bytes(points.normals), ids).ok());
    ASSERT_TRUE(cloud.Finish().ok());
    const absl::Status status = cloud.Rank();
    EXPECT_EQ(KindOf(status), ErrorKind::kRepeatedId);
    EXPECT_NE(status.message().find("ids of points 0 and "), std::string::npos) << status;
  }
}

TEST(CloudTest, RefusesAsManyIdsOrRolesAsThereAreNoPoints) {
  const TestPoints points = Sphere(3, 1.0);
  for (const auto& [ids, roles] : {std::pair(2, 0), std::pair(4, 0), std::pair(3, 2), std::pair(3, 4)}) {
    Cloud cloud;
    const std::vector<uint64_t> all = {0, 5, 9, 11};
    const std::vector<PointRole> some(static_cast<size_t>(roles), PointRole::kHalo);
    const absl::Status status = cloud.AppendPart(Bytes(points.positions), Bytes(points.normals),
                                                 std::span(all).first(static_cast<size_t>(ids)), some);
    EXPECT_EQ(KindOf(status), ErrorKind::kInvalid) << ids << " ids, " << roles << " roles";
    EXPECT_EQ(cloud.size(), 0u);
  }
}

TEST(CloudTest, ARefusedPointTakesItsRoleAlong) {
  TestPoints points = Sphere(4, 1.0);
  points.normals[2] = {0, 0, 0};
  const std::vector<PointRole> roles = {PointRole::kHalo, PointRole::kQuery, PointRole::kQuery, PointRole::kHalo};
  Cloud cloud;
  EXPECT_EQ(KindOf(cloud.AppendPart(Bytes(points.positions), Bytes(points.normals), std::vector<uint64_t>{1, 2, 3, 4},
                                    roles)),
            ErrorKind::kInvalid);
  EXPECT_EQ(cloud.size(), 2u);
  EXPECT_EQ(cloud.point_set().size(), 2u);
  EXPECT_EQ(cloud.point_set().query_count(), 1u);
}

TEST(CloudTest, WithoutNormalsIsIndexedAndRefusedByWhatNeedsThem) {
  const TestPoints points = Sphere(3'000, 1.0);
  const auto bare = [&](bool expected) {
    Cloud cloud(ScalarType::kFloat32, InvalidPointPolicy::kReject, NormalsInput::kAbsent);
    if (expected) cloud.Expect(points.size());
    EXPECT_TRUE(cloud.Append(Bytes(points.positions), {}).ok());
    EXPECT_EQ(KindOf(cloud.Append({}, "x")), ErrorKind::kInvalid);
    EXPECT_TRUE(cloud.Finish().ok());
    return cloud;
  };
  EXPECT_EQ(bare(true).bytes(), 3'000 * sizeof(PointRecord));
  const SpatialIndex with = BuildIndex(points.ToCloud());
  for (const bool expected : {true, false}) {
    const SpatialIndex without = BuildIndex(bare(expected));
    EXPECT_FALSE(without.has_normals());
    EXPECT_LT(without.bytes(), with.bytes());
    for (size_t leaf = 0; leaf < with.leaf_count(); ++leaf) {
      for (int i = 0; i < with.LeafPoints(leaf); ++i) {
        ASSERT_EQ(without.positions(leaf).id[i], with.positions(leaf).id[i]);
        ASSERT_EQ(without.positions(leaf).x[i], with.positions(leaf).x[i]);
      }
    }
  }
  WorkerPool pool(2);
  const absl::Status status = EstimateCurvature(bare(true), {}, pool).status();
  EXPECT_EQ(KindOf(status), ErrorKind::kInvalid);
  EXPECT_NE(status.message().find("avg-hexagram"), std::string::npos) << status;
}

}  // namespace
}  // namespace curvd::testing
