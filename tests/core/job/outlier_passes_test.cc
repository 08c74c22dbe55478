// Estimates of a cloud in passes, each without the outliers that those before have found.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <latch>
#include <limits>

#include "core/base/error.h"
#include "core/job/estimation_job.h"
#include "core/job/job_memory.h"
#include "core/job/worker_pool.h"
#include "core/scale/outliers/outlier_run.h"
#include "tests/core/normals/normal_clouds.h"
#include "tests/core/scale/automatic_requests.h"
#include "tests/core/scale/outliers/outlier_clouds.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

// What a cloud has in which the same points are invalid. Normals are rounded once more, by which an estimate that is
// just large enough to count in a group may not count there: these differ by what they err by.
TEST(OutlierPassesTest, OutliersBesideExactPointsAreNobodysNeighbors) {
  const TorusWithOutliers cloud = WithOutliersNearby(0.0, 300);
  const EstimationResult result = MustEstimate(cloud.points().ToCloud(), Automatic());
  const OutlierOutcome outcome = OutcomeOf(cloud, result);
  EXPECT_EQ(outcome.found, 300u);
  EXPECT_EQ(outcome.mistaken, 0u);
  EXPECT_EQ(CountOutliers(result), 300u);
  EXPECT_EQ(result.field.status_counts[static_cast<size_t>(PointStatus::kInvalidInput)], 0u);
  EXPECT_EQ(result.field.status_counts[static_cast<size_t>(PointStatus::kOk)], kTorusPoints);
  const EstimationResult without = MustEstimate(cloud.WithInvalidOnes(), Automatic());
  for (size_t i = 0; i < kTorusPoints; ++i) {
    ASSERT_NEAR(result.field.points[i].mean, without.field.points[i].mean, 1e-4) << i;
  }
  for (size_t i = kTorusPoints; i < cloud.points().size(); ++i) {
    const PointCurvature& point = result.field.points[i];
    EXPECT_TRUE(std::isnan(point.mean) && std::isnan(point.k1) && std::isnan(point.d1[0]) && std::isnan(point.radius));
  }
}

// What an outlier's normal is opposed to is no seam.
TEST(OutlierPassesTest, SeamsAreRejectedWithoutOutliers) {
  EstimatorOptions rejects = Automatic();
  rejects.opposed_normals = OpposedNormalsPolicy::kReject;
  TestPoints points = TorusWithoutOutliers(0.1).points();
  for (size_t i = 0; i < kTorusPoints; i += 200) {
    for (float& component : points.normals[i]) component = -component;
  }
  EXPECT_EQ(CountOutliers(MustEstimate(points.ToCloud(), rejects)), kTorusPoints / 200);
  for (size_t i = 0; i < kTorusPoints; ++i) {
    if (!(points.positions[i][0] > 0.0f)) continue;
    for (float& component : points.normals[i]) component = -component;
  }
  WorkerPool pool(2);
  const auto result = EstimateCurvature(points.ToCloud(), rejects, pool);
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(KindOf(result.status()), ErrorKind::kOpposedNormals);
}

// The second pass starts from the normals of the first one's caller.
TEST(OutlierPassesTest, TurnedNormalsAreThoseThatTheCallerSent) {
  TorusWithOutliers cloud = WithOutliersNearby(0.0, 20);
  size_t inward = 0;
  for (size_t i = 0; i < kTorusPoints; i += 3) {
    for (float& component : cloud.points().normals[i]) component = -component;
    ++inward;
  }
  NormalOptions orient;
  orient.source = NormalSource::kOrient;
  WorkerPool pool(2);
  const auto result = EstimateCurvature(cloud.points().ToCloud(), Automatic(), orient, pool);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(OutcomeOf(cloud, *result).found, 20u);
  ASSERT_TRUE(result->normal_report.has_value());
  EXPECT_EQ(result->normal_report->flipped_count, inward);
  EXPECT_LE(result->cost.peak_bytes, cloud.points().size() * EstimationBytesPerPoint(Automatic(), orient) +
                                         EstimationScratchBytes(Automatic(), cloud.points().size(), 2, orient))
      << "they are kept meanwhile";
}

TEST(OutlierPassesTest, NormalsThatAreReturnedSayWhoIsAnOutlier) {
  const TorusWithOutliers cloud = WithOutliersNearby(0.0, 20);
  WorkerPool pool(2);
  NormalOptions normals = Estimated();
  normals.returns_normals = true;
  const auto result = EstimateCurvature(BareCloud(cloud.points()), Automatic(), normals, pool);
  ASSERT_TRUE(result.ok());
  for (size_t i = kTorusPoints; i < cloud.points().size(); ++i) {
    EXPECT_EQ(result->normals[i].status, PointStatus::kOutlier);
    EXPECT_TRUE(std::isnan(result->normals[i].normal[0]));
  }
}

TEST(OutlierPassesTest, OnlyAChoiceOfBothLooksForThem) {
  const TorusWithOutliers cloud = WithOutliersNearby(0.0, 20);
  EstimatorOptions count = Automatic(), estimator = Automatic();
  count.neighborhood = NeighborCount{32};
  estimator.estimator = "avg-hexagram";
  for (const EstimatorOptions& options : {count, estimator, EstimatorOptions()}) {
    EXPECT_FALSE(LooksForOutliers(options));
    EXPECT_EQ(CountOutliers(MustEstimate(cloud.points().ToCloud(), options)), 0u);
  }
  EXPECT_TRUE(LooksForOutliers(Automatic()));
  EXPECT_TRUE(LooksForOutliers(Automatic({.per_cloud = true})));
}

TEST(OutlierPassesTest, NeitherThreadsNorUnitsMatter) {
  const TorusWithOutliers cloud = WithOutliersAnywhere(0.1, 300);
  const EstimationResult one = MustEstimate(cloud.points().ToCloud(), WithChoice(Automatic()), 1);
  const EstimationResult three = MustEstimate(cloud.points().ToCloud(), WithChoice(Automatic()), 3);
  EXPECT_GT(CountOutliers(one), 250u);
  EXPECT_EQ(FirstDifference(one.field.points.span(), three.field.points.span()), cloud.points().size());
  EXPECT_TRUE(AreSameBytes(one.choices, three.choices));
  TestPoints larger = cloud.points();
  for (auto& position : larger.positions) {
    for (float& coordinate : position) coordinate *= 1024.0f;
  }
  const EstimationResult scaled = MustEstimate(larger.ToCloud(), Automatic());
  for (size_t i = 0; i < cloud.points().size(); ++i) {
    ASSERT_EQ(scaled.field.points[i].status, one.field.points[i].status) << i;
    if (one.field.points[i].status != PointStatus::kOk) continue;
    ASSERT_EQ(scaled.field.points[i].mean * 1024.0f, one.field.points[i].mean) << i;
  }
}

// The rest of a cloud is put together in blocks of 65,536 points.
TEST(OutlierPassesTest, ALargeCloudKeepsItsPoints) {
  TestPoints points = Waves(70'000, 0.0, 3), without = points;
  for (const size_t i : {size_t{0}, size_t{65'535}, size_t{65'536}, size_t{69'999}}) {
    points.positions[i][2] += 0.1f;
    without.positions[i][0] = std::numeric_limits<float>::quiet_NaN();
  }
  const EstimationResult found = MustEstimate(points.ToCloud(), Automatic());
  const EstimationResult expected = MustEstimate(without.ToCloud(), Automatic());
  for (size_t i = 0; i < points.size(); ++i) {
    const PointCurvature &point = found.field.points[i], &of_rest = expected.field.points[i];
    if (of_rest.status == PointStatus::kInvalidInput) {
      ASSERT_EQ(point.status, PointStatus::kOutlier) << i;
      continue;
    }
    ASSERT_EQ(point.status, of_rest.status) << i;
    ASSERT_NEAR(point.mean, of_rest.mean, 1e-3) << i;
  }
  // The results are gone before the rest is made.
  EXPECT_LE(found.cost.peak_bytes, expected.cost.peak_bytes + points.size());
}

TEST(OutlierPassesTest, TheCostIsThatOfAllPasses) {
  const TorusWithOutliers cloud = WithOutliersNearby(0.0, 20);
  const EstimationResult result = MustEstimate(cloud.points().ToCloud(), Automatic());
  const JobCost& cost = result.cost;
  EXPECT_GT(SecondsOf(cost.phases, kOutlierPhase), 0.0);
  size_t indexed = 0;
  for (const PhaseTime& phase : cost.phases) indexed += phase.name == "index" ? 1 : 0;
  EXPECT_GE(indexed, 2u);
  EXPECT_GE(*cost.seconds.estimate, SecondsOf(cost.phases, "curvature"));
}

// Progress never goes back, and a job that is cancelled in its second pass ends.
TEST(OutlierPassesTest, TheSecondPassCanBeCancelled) {
  const TorusWithOutliers cloud = WithOutliersNearby(0.0, 100);
  WorkerPool pool(2);
  std::latch done(1);
  absl::Status status;
  const auto job = EstimationJob::Start(cloud.points().ToCloud(), Automatic(), pool, JobPriority::kBatch,
                                        [&](absl::StatusOr<EstimationResult> result) {
                                          status = result.status();
                                          done.count_down();
                                        });
  size_t before = 0;
  bool was_estimated = false;
  while (!done.try_wait()) {
    const JobProgress progress = job->progress();
    EXPECT_GE(progress.points_estimated, before);
    before = progress.points_estimated;
    was_estimated = was_estimated || before == cloud.points().size();
    // All points are estimated, and the index is made again.
    if (was_estimated && progress.phase == JobPhase::kIndexing) job->Cancel();
  }
  done.wait();
  EXPECT_TRUE(was_estimated);
  EXPECT_TRUE(status.ok() || KindOf(status) == ErrorKind::kCancelled) << status;
}

}  // namespace
}  // namespace curvd::testing
