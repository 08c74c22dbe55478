#include "core/job/normals_job.h"

#include <gtest/gtest.h>

#include <latch>
#include <utility>

#include "core/base/error.h"
#include "core/job/phases/normal_phases.h"
#include "core/job/phases/normal_tasks.h"
#include "tests/core/normals/normal_clouds.h"
#include "tests/core/sanitized.h"

namespace curvd::testing {
namespace {

TEST(NormalsJobTest, ThreadsDoNotChangeAByte) {
  TestPoints torus = Torus(kSanitized ? 20'000 : 60'000, 1);
  AddNoise(0.1, 2, torus);
  TestPoints turned = torus;
  FlipAtRandom(0.5, 3, turned);
  NormalOptions orient;
  orient.source = NormalSource::kOrient;
  const NormalResult estimated = MustMakeNormals(BareCloud(torus), Estimated(), 1);
  const NormalResult oriented = MustMakeNormals(turned.ToCloud(), orient, 1);
  for (const int threads : {2, 5}) {
    const NormalResult other = MustMakeNormals(BareCloud(torus), Estimated(), threads);
    EXPECT_TRUE(SameBytes(estimated.normals, other.normals));
    EXPECT_EQ(estimated.report.sigma, other.report.sigma);
    EXPECT_EQ(estimated.report.certificate, other.report.certificate);
    EXPECT_TRUE(SameBytes(oriented.normals, MustMakeNormals(turned.ToCloud(), orient, threads).normals));
  }
}

TEST(NormalsJobTest, GivenNormalsComeBackAsTheyAre) {
  const TestPoints torus = Torus(1000, 1);
  const NormalResult result = MustMakeNormals(torus.ToCloud(), NormalOptions());
  const Cloud cloud = torus.ToCloud();
  for (size_t i = 0; i < torus.size(); ++i) ASSERT_EQ(result.normals[i].normal, cloud.normal(i));
}

TEST(NormalsJobTest, AbsentNormalsCanOnlyBeEstimated) {
  WorkerPool pool(1);
  for (const NormalSource source : {NormalSource::kGiven, NormalSource::kOrient}) {
    NormalOptions options;
    options.source = source;
    const auto result = MakeNormals(BareCloud(Sphere(100, 1.0)), options, pool);
    EXPECT_EQ(result.status().code(), absl::StatusCode::kInvalidArgument);
  }
}

TEST(NormalsJobTest, RefusesOptionsOutOfRangeAndRadiiThatHoldTooMany) {
  WorkerPool pool(2);
  NormalOptions options = Estimated();
  options.neighborhood = NeighborCount{2};
  EXPECT_EQ(KindOf(MakeNormals(BareCloud(Sphere(100, 1.0)), options, pool).status()), ErrorKind::kInvalid);
  options.neighborhood = NeighborRadius{10.0};
  options.max_neighbor_count = 50;
  EXPECT_EQ(KindOf(MakeNormals(BareCloud(Sphere(100, 1.0)), options, pool).status()), ErrorKind::kNeighborhoodTooLarge);
}

TEST(NormalsJobTest, CancelEndsTheJob) {
  WorkerPool pool(1);
  std::latch done(1);
  absl::Status status;
  const auto job = EstimationJob::StartNormals(BareCloud(Sphere(200'000, 1.0)), Estimated(), pool, JobPriority::kBatch,
                                               [&](absl::StatusOr<EstimationResult> result) {
                                                 status = result.status();
                                                 done.count_down();
                                               });
  job->Cancel();
  done.wait();
  EXPECT_EQ(KindOf(status), ErrorKind::kCancelled);
}

TEST(NormalsJobTest, ComesToThePhasesOfNormalsAndToNoneOfCurvature) {
  WorkerPool pool(2);
  std::latch done(1);
  EstimationResult result;
  const auto job = EstimationJob::StartNormals(BareCloud(Torus(20'000, 3)), Estimated(), pool, JobPriority::kBatch,
                                               [&](absl::StatusOr<EstimationResult> made) {
                                                 if (made.ok()) result = *std::move(made);
                                                 done.count_down();
                                               });
  done.wait();
  const JobSeconds seconds = job->progress().seconds;
  EXPECT_GT(seconds.index, 0.0);
  EXPECT_GT(seconds.normals, 0.0);
  EXPECT_GT(seconds.orientation, 0.0);
  EXPECT_FALSE(seconds.estimate.has_value());
  EXPECT_EQ(result.cost.seconds.normals, seconds.normals);
  EXPECT_EQ(result.field.points.size(), 0u);
  EXPECT_EQ(result.field.status_counts[static_cast<size_t>(PointStatus::kOk)], 20'000u);
  EXPECT_EQ(result.normals.size(), 20'000u) << "handed out, whatever the options say";
}

TEST(NormalsJobTest, IsNeverInThePhaseOfCurvature) {
  WorkerPool pool(1);
  bool has_estimated = false;
  // A job that has ended frees its index before it is done, and whoever asks meanwhile hears of it.
  for (int round = 0; round < 5; ++round) {
    std::latch done(1);
    const auto job = EstimationJob::StartNormals(BareCloud(Torus(20'000, 3)), Estimated(), pool, JobPriority::kBatch,
                                                 [&](const absl::StatusOr<EstimationResult>&) { done.count_down(); });
    while (!done.try_wait()) has_estimated |= job->progress().phase == JobPhase::kEstimating;
  }
  EXPECT_FALSE(has_estimated);
}

TEST(NormalsJobTest, CountsInvalidPointsOfNormalsThatAreGiven) {
  TestPoints points = Sphere(100, 1.0);
  points.normals[3] = {0.0f, 0.0f, 0.0f};
  WorkerPool pool(1);
  const auto result = MakeNormals(points.ToCloud(), NormalOptions(), pool);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->report.status_counts[static_cast<size_t>(PointStatus::kOk)], 99u);
  EXPECT_EQ(result->report.status_counts[static_cast<size_t>(PointStatus::kInvalidInput)], 1u);
}

TEST(NormalsJobTest, HaloPointsGetNormalsAndNoResult) {
  const TestPoints torus = Torus(6000, 4);
  std::vector<uint64_t> ids(torus.size());
  std::vector<PointRole> roles(torus.size());
  for (size_t i = 0; i < ids.size(); ++i) {
    ids[i] = 2 * i;
    roles[i] = i % 3 == 0 ? PointRole::kHalo : PointRole::kQuery;
  }
  Cloud cloud(ScalarType::kFloat32, InvalidPointPolicy::kReject, NormalsInput::kAbsent);
  const size_t bytes = torus.size() * sizeof(torus.positions[0]);
  ASSERT_TRUE(cloud.AppendPart({reinterpret_cast<const char*>(torus.positions.data()), bytes}, {}, ids, roles).ok());
  ASSERT_TRUE(cloud.Finish().ok());
  const NormalResult part = MustMakeNormals(std::move(cloud), EstimateBy(NormalMethod::kJet2, 30));
  const NormalResult whole = MustMakeNormals(BareCloud(torus), EstimateBy(NormalMethod::kJet2, 30));
  ASSERT_EQ(part.normals.size(), 4000u);
  EXPECT_EQ(part.report.status_counts[static_cast<size_t>(PointStatus::kOk)], 4000u);
  size_t slot = 0;
  for (size_t i = 0; i < torus.size(); ++i) {
    if (roles[i] == PointRole::kHalo) continue;
    ASSERT_EQ(part.normals[slot++].normal, whole.normals[i].normal);
  }
}

TEST(NormalsJobTest, PeakStaysBelowThePromise) {
  constexpr size_t kPoints = 300'000;
  for (const bool noisy : {false, true}) {
    TestPoints torus = Torus(kPoints, 5);
    if (noisy) AddNoise(0.1, 6, torus);
    NormalOptions options = Estimated();
    options.returns_normals = true;
    const NormalResult result = MustMakeNormals(BareCloud(torus), options);
    // The cloud and the index take what EstimationBytesPerPoint counts for them, less the cloud's normals.
    EXPECT_LE(result.cost.peak_bytes,
              kPoints * (48 - 12 + NormalBytesPerPoint(options, TasksFor(std::nullopt, options))));
    EXPECT_GT(SecondsOf(result.cost.phases, "normals"), 0.0);
    EXPECT_GT(SecondsOf(result.cost.phases, "orientation"), 0.0);
  }
}

}  // namespace
}  // namespace curvd::testing
