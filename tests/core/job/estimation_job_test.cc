#include "core/job/estimation_job.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <latch>
#include <limits>
#include <memory>

#include "core/base/error.h"
#include "core/base/page_pool.h"
#include "core/job/job_memory.h"
#include "core/scale/outliers/outlier_run.h"
#include "tests/core/normals/normal_clouds.h"
#include "tests/core/sanitized.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

using ::testing::Contains;

bool SameFields(const CurvatureField& a, const CurvatureField& b) {
  return a.points.size() == b.points.size() && FirstDifference(a.points.span(), b.points.span()) == a.points.size();
}

EstimatorOptions WithEstimator(std::string_view estimator) {
  EstimatorOptions options;
  options.estimator = estimator;
  return options;
}

uint64_t CountOf(const EstimationResult& result, PointStatus status) {
  return result.field.status_counts[static_cast<size_t>(status)];
}

TEST(EstimationJobTest, SphereHasTheCurvatureOfItsRadius) {
  for (std::string_view estimator : kEstimators) {
    const EstimationResult result = MustEstimate(Sphere(20'000, 2.0).ToCloud(), WithEstimator(estimator));
    for (size_t i = 0; i < result.field.points.size(); ++i) {
      const PointCurvature& point = result.field.points[i];
      ASSERT_EQ(point.status, PointStatus::kOk);
      // Independent triangles are few and thin: their error is the largest.
      ASSERT_NEAR(point.mean, 0.5f, 0.01f);
      ASSERT_NEAR(point.gaussian, 0.25f, 0.01f);
      ASSERT_LE(point.k1, point.k2);
    }
  }
}

// 1e-4: float sums in another order, in the worst of the estimators; without care for outliers nothing was right.
TEST(EstimationJobTest, AnOutlierOfAnySizeChangesNothingButItsOwnResult) {
  constexpr size_t kPoints = 5'000;
  for (std::string_view estimator : kEstimators) {
    const EstimationResult alone = MustEstimate(Sphere(kPoints, 1.0).ToCloud(), WithEstimator(estimator));
    for (const double far : {1e6, 1e12, 5e20, 1e30, 3e38}) {
      TestPoints points = Sphere(kPoints, 1.0);
      points.Add(far, 0.0, 0.0, 0.0, 0.0, 1.0);
      const EstimationResult beside = MustEstimate(points.ToCloud(), WithEstimator(estimator));
      for (size_t i = 0; i < kPoints; ++i) {
        const PointCurvature &expected = alone.field.points[i], &point = beside.field.points[i];
        ASSERT_EQ(point.status, expected.status) << estimator << " " << far << " " << i;
        ASSERT_NEAR(point.mean, expected.mean, 1e-4f) << estimator << " " << far << " " << i;
        ASSERT_NEAR(point.radius, expected.radius, 1e-6f) << estimator << " " << far << " " << i;
      }
      ASSERT_NE(beside.field.points[kPoints].status, PointStatus::kOk) << estimator << " " << far;
    }
  }
}

TEST(EstimationJobTest, ThreadsDoNotChangeAByte) {
  for (std::string_view estimator : kEstimators) {
    const TestPoints points = RandomPoints(Layout::kClustered, kSanitized ? 12'500 : 50'000, 3);
    const EstimationResult one = MustEstimate(points.ToCloud(), WithEstimator(estimator), 1);
    for (int threads : {2, 8}) {
      EXPECT_TRUE(SameFields(one.field, MustEstimate(points.ToCloud(), WithEstimator(estimator), threads).field));
    }
  }
}

// Leaves every page that arrays of `points` points may get with `byte` in each place; returns where they begin.
std::vector<const void*> SoilPages(size_t points, int byte) {
  std::vector<std::pair<void*, size_t>> ranges;
  for (const size_t bytes : {4u, 12u, 16u, 24u, 28u, 32u, 48u, 64u}) {
    for (size_t size = points * bytes / 16; size <= points * bytes + 8192; size += std::max<size_t>(4096, size / 64)) {
      ranges.emplace_back(ProcessPages().Map(size), size);
      std::memset(ranges.back().first, byte, size);
    }
  }
  std::vector<const void*> soiled;
  for (const auto& [pages, size] : ranges) {
    ProcessPages().Unmap(pages, size);
    soiled.push_back(pages);
  }
  return soiled;
}

// Arrays get the pages of those that died, with what is written there.
TEST(EstimationJobTest, WhatPagesHeldBeforeDoesNotChangeAByte) {
  for (std::string_view estimator : kEstimators) {
    for (const bool by_radius : {false, true}) {
      EstimatorOptions options = WithEstimator(estimator);
      if (by_radius) options.neighborhood = NeighborRadius{0.05};
      for (const size_t count : {10, 1'000, kSanitized ? 2'001 : 5'001}) {
        TestPoints points = RandomPoints(Layout::kClustered, count, 5);
        points.normals[3] = {0.0f, 0.0f, 0.0f};
        const EstimationResult fresh = MustEstimate(points.ToCloud(), options, 2);
        for (const int byte : {0xff, 0x7f, 0x01}) {
          ProcessPages().SetLimits({.kept = 256 << 20, .together = 1 << 30});
          const std::vector<const void*> soiled = SoilPages(count, byte);
          const EstimationResult reused = MustEstimate(points.ToCloud(), options, 2);
          EXPECT_THAT(soiled, Contains(reused.field.points.data()));
          ProcessPages().SetLimits({});
          EXPECT_TRUE(SameFields(fresh.field, reused.field)) << estimator << ", " << count << " points";
        }
      }
    }
  }
}

TEST(EstimationJobTest, SeedChangesOnlyRandomStrategies) {
  for (std::string_view estimator : kEstimators) {
    EstimatorOptions options = WithEstimator(estimator);
    const TestPoints points = Sphere(2000, 1.0);
    const EstimationResult first = MustEstimate(points.ToCloud(), options);
    options.seed = 1;
    const bool same = SameFields(first.field, MustEstimate(points.ToCloud(), options).field);
    EXPECT_EQ(same, estimator != "uniform" && estimator != "independent");
  }
}

TEST(EstimationJobTest, EmptyCloudGivesEmptyField) {
  EXPECT_EQ(MustEstimate(TestPoints().ToCloud(), {}).field.points.size(), 0u);
}

TEST(EstimationJobTest, FewerPointsThanNeighborsIsTooFew) {
  for (size_t n : {size_t{1}, size_t{3}, size_t{49}}) {
    const EstimationResult result = MustEstimate(Sphere(n, 1.0).ToCloud(), {});
    EXPECT_EQ(CountOf(result, PointStatus::kTooFewNeighbors), n);
    EXPECT_TRUE(std::isnan(result.field.points[0].mean));
  }
  EXPECT_EQ(CountOf(MustEstimate(Sphere(50, 1.0).ToCloud(), {}), PointStatus::kTooFewNeighbors), 0u);
}

TEST(EstimationJobTest, LonelyPointsOfARadiusNeighborhoodAreTooFewAndKeepTheRadius) {
  EstimatorOptions options;
  options.neighborhood = NeighborRadius{1e-3};
  const EstimationResult result = MustEstimate(Sphere(100, 1.0).ToCloud(), options);
  EXPECT_EQ(CountOf(result, PointStatus::kTooFewNeighbors), 100u);
  EXPECT_EQ(result.field.points[5].radius, 1e-3f);
}

TEST(EstimationJobTest, CoincidentAndCollinearPointsAreDegenerate) {
  for (std::string_view estimator : kEstimators) {
    TestPoints same, line;
    for (int i = 0; i < 5000; ++i) {
      same.Add(1, 2, 3, 0, 0, 1);
      line.Add(0.001 * i, 0, 0, 0, 0, 1);
    }
    EXPECT_EQ(CountOf(MustEstimate(same.ToCloud(), WithEstimator(estimator)), PointStatus::kDegenerateArea), 5000u);
    const bool is_fit = estimator == "jet" || estimator == "aso" || estimator == "normal-regression";
    const PointStatus expected = is_fit ? PointStatus::kSingularFit : PointStatus::kDegenerateArea;
    EXPECT_EQ(CountOf(MustEstimate(line.ToCloud(), WithEstimator(estimator)), expected), 5000u);
  }
}

TEST(EstimationJobTest, FewerNeighborsThanCoefficientsAreASingularFit) {
  EstimatorOptions options = WithEstimator("jet");
  for (const auto& [degree, coefficients] : {std::pair(2u, 6u), std::pair(3u, 10u), std::pair(4u, 15u)}) {
    options.jet_degree = degree;
    options.neighborhood = NeighborCount{coefficients - 1};
    EXPECT_EQ(CountOf(MustEstimate(Sphere(500, 1.0).ToCloud(), options), PointStatus::kSingularFit), 500u);
    options.neighborhood = NeighborCount{coefficients + 3};
    EXPECT_EQ(CountOf(MustEstimate(Sphere(500, 1.0).ToCloud(), options), PointStatus::kOk), 500u) << degree;
  }
}

TEST(EstimationJobTest, PointsOnTwoParallelLinesFixNoJet) {
  // y, y^2 and 1 depend on each other where y takes two values: the conic is not unique.
  TestPoints lines;
  for (int i = 0; i < 1000; ++i) lines.Add(0.01 * i, i % 2, 0, 0, 0, 1);
  EstimatorOptions options = WithEstimator("jet");
  options.neighborhood = NeighborRadius{1.5};
  EXPECT_EQ(CountOf(MustEstimate(lines.ToCloud(), options), PointStatus::kSingularFit), 1000u);
}

TEST(EstimationJobTest, JetsNeedNormalsOnlyForTheSign) {
  TestPoints points = Waves(2000, 0.0, 1);
  const EstimatorOptions options = WithEstimator("jet");
  const EstimationResult upward = MustEstimate(points.ToCloud(), options);
  // Tilted by up to 40 degrees, and to the other side.
  for (size_t i = 0; i < points.size(); ++i) {
    for (float& component : points.normals[i]) component = -component;
    points.normals[i][i % 3] += i % 2 == 0 ? 0.4f : -0.4f;
  }
  const EstimationResult downward = MustEstimate(points.ToCloud(), options);
  for (size_t i = 0; i < points.size(); ++i) {
    ASSERT_EQ(downward.field.points[i].status, PointStatus::kOk);
    ASSERT_EQ(downward.field.points[i].mean, -upward.field.points[i].mean);
    ASSERT_EQ(downward.field.points[i].gaussian, upward.field.points[i].gaussian);
  }
}

TEST(EstimationJobTest, PlaneIsExactlyFlat) {
  const EstimationResult result = MustEstimate(RandomPoints(Layout::kLattice, 144, 0).ToCloud(), {});
  TestPoints plane = RandomPoints(Layout::kCoplanar, 5000, 1);
  for (auto& normal : plane.normals) normal = {0, 0, 1};
  for (std::string_view estimator : kEstimators) {
    const EstimationResult flat = MustEstimate(plane.ToCloud(), WithEstimator(estimator));
    for (size_t i = 0; i < plane.size(); ++i) {
      ASSERT_EQ(flat.field.points[i].status, PointStatus::kOk);
      ASSERT_EQ(flat.field.points[i].mean, 0.0f);
      ASSERT_EQ(flat.field.points[i].gaussian, 0.0f);
    }
  }
}

TEST(EstimationJobTest, CancellingNormalsOfTwoSheetsAreInconsistent) {
  TestPoints sheets = RandomPoints(Layout::kCoplanar, 2000, 2);
  for (size_t i = 0; i < sheets.size(); ++i) {
    const float side = i % 2 == 0 ? 1.0f : -1.0f;
    sheets.positions[i][2] += 0.02f * side;
    sheets.normals[i] = {0, 0, side};
  }
  for (const std::string_view estimator : {"avg-hexagram", "aso", "normal-regression"}) {
    const EstimationResult result = MustEstimate(sheets.ToCloud(), WithEstimator(estimator));
    EXPECT_GT(CountOf(result, PointStatus::kInconsistentNormals), 0u) << estimator;
    EXPECT_EQ(CountOf(result, PointStatus::kOpposedNormals), 0u) << estimator;
  }
}

TEST(EstimationJobTest, InvalidPointsAreSkippedAndNobodysNeighbors) {
  TestPoints points = Sphere(3000, 1.0), clean = points;
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  points.Add(nan, 0, 1, 0, 0, 1);
  points.Add(0, infinity, 1, 0, 0, 1);
  points.Add(0, 0, 1, 0, 0, 0);
  points.Add(0, 0, 1, nan, 0, 0);
  const EstimationResult result = MustEstimate(points.ToCloud(), {});
  EXPECT_EQ(CountOf(result, PointStatus::kInvalidInput), 4u);
  EXPECT_TRUE(std::isnan(result.field.points[3001].mean));
  const EstimationResult expected = MustEstimate(clean.ToCloud(), {});
  for (size_t i = 0; i < clean.size(); ++i) ASSERT_EQ(result.field.points[i].mean, expected.field.points[i].mean);
}

TEST(EstimationJobTest, PowerOfTwoScalesGiveTheSameDigits) {
  for (std::string_view estimator : kEstimators) {
    const EstimatorOptions options = WithEstimator(estimator);
    const EstimationResult unit = MustEstimate(Sphere(3000, 1.0).ToCloud(), options);
    for (double scale : {0x1p-100, 0x1p-20, 0x1p20, 0x1p100}) {
      const EstimationResult scaled = MustEstimate(Sphere(3000, scale).ToCloud(), options);
      for (size_t i = 0; i < 3000; ++i) {
        ASSERT_EQ(scaled.field.points[i].status, std::abs(std::log2(scale)) > 63 && scale < 1
                                                     ? PointStatus::kDegenerateArea  // 1 / scale^2 is no float
                                                     : PointStatus::kOk);
        if (scaled.field.points[i].status != PointStatus::kOk) continue;
        ASSERT_FLOAT_EQ(static_cast<float>(scaled.field.points[i].mean * scale), unit.field.points[i].mean);
      }
    }
  }
}

TEST(EstimationJobTest, RadiusThatCoversTheCloudIsRefusedByTheLimit) {
  EstimatorOptions options;
  options.neighborhood = NeighborRadius{100.0};
  options.max_neighbor_count = 1000;
  WorkerPool pool(2);
  const auto result = EstimateCurvature(Sphere(20'000, 1.0).ToCloud(), options, pool);
  EXPECT_EQ(result.status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_NE(result.status().message().find("1000"), std::string::npos) << result.status();
}

TEST(EstimationJobTest, SpheresHaveTheirCurvatureWithoutNormalsToo) {
  WorkerPool pool(2);
  for (std::string_view estimator : kEstimators) {
    const auto result = EstimateCurvature(BareCloud(Sphere(kSanitized ? 5'000 : 20'000, 2.0)), WithEstimator(estimator),
                                          Estimated(), pool);
    ASSERT_TRUE(result.ok()) << result.status();
    for (size_t i = 0; i < result->field.points.size(); ++i) {
      ASSERT_EQ(result->field.points[i].status, PointStatus::kOk);
      ASSERT_NEAR(result->field.points[i].mean, 0.5f, 0.01f) << estimator;
    }
    EXPECT_EQ(result->normal_report->closed_piece_count, 1u);
    EXPECT_EQ(result->normals.size(), 0u);
  }
}

TEST(EstimationJobTest, TurnedNormalsAreOrientedOnRequest) {
  WorkerPool pool(2);
  TestPoints sphere = Sphere(5'000, 2.0);
  const auto expected = EstimateCurvature(sphere.ToCloud(), EstimatorOptions(), pool);
  for (size_t i = 0; i < sphere.size(); i += 2) {
    for (float& component : sphere.normals[i]) component = -component;
  }
  NormalOptions normals;
  normals.source = NormalSource::kOrient;
  normals.returns_normals = true;
  const auto result = EstimateCurvature(sphere.ToCloud(), EstimatorOptions(), normals, pool);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_TRUE(SameFields(result->field, expected->field));
  EXPECT_EQ(result->normal_report->flipped_count, 2'500u);
  ASSERT_EQ(result->normals.size(), sphere.size());
  EXPECT_GT(result->normals[0].normal[2], 0.0f);  // the first point is at the top
}

TEST(EstimationJobTest, ThreadsDoNotChangeAByteOfWhatEstimatedNormalsGive) {
  const TestPoints points = Waves(kSanitized ? 10'000 : 30'000, 0.002, 3);
  WorkerPool one(1), four(4);
  const auto first = EstimateCurvature(BareCloud(points), EstimatorOptions(), Estimated(), one);
  const auto second = EstimateCurvature(BareCloud(points), EstimatorOptions(), Estimated(), four);
  EXPECT_TRUE(SameFields(first->field, second->field));
}

TEST(EstimationJobTest, PointsWithoutANormalHaveItsStatusAndSpoilNoOther) {
  WorkerPool pool(2);
  for (std::string_view estimator : kEstimators) {
    TestPoints points = Sphere(5'000, 1.0);
    for (int i = 0; i < 200; ++i) points.Add(5.0, 0, 0, 0, 0, 1);          // at one place
    for (int i = 0; i < 200; ++i) points.Add(-5.0, 0.01 * i, 0, 0, 0, 1);  // on a line
    const auto result = EstimateCurvature(BareCloud(points), WithEstimator(estimator), Estimated(), pool);
    ASSERT_TRUE(result.ok()) << result.status();
    EXPECT_EQ(CountOf(*result, PointStatus::kDegenerateArea), 200u) << estimator;
    EXPECT_EQ(CountOf(*result, PointStatus::kSingularFit), 200u) << estimator;
    EXPECT_EQ(CountOf(*result, PointStatus::kOk), 5'000u) << estimator;
    EXPECT_TRUE(std::isnan(result->field.points[5'100].mean));
  }
}

TEST(EstimationJobTest, AbsentNormalsAreAnErrorThatSaysWhatToDo) {
  WorkerPool pool(1);
  NormalOptions orient;
  orient.source = NormalSource::kOrient;
  EXPECT_EQ(KindOf(EstimateCurvature(BareCloud(Sphere(100, 1.0)), {}, pool).status()), ErrorKind::kInvalid);
  EXPECT_EQ(KindOf(EstimateCurvature(BareCloud(Sphere(100, 1.0)), {}, orient, pool).status()), ErrorKind::kInvalid);
}

TEST(EstimationJobTest, PeakWithEstimatedNormalsStaysBelowThePromise) {
  WorkerPool pool(2);
  NormalOptions normals = Estimated();
  for (const bool returns : {false, true}) {
    normals.returns_normals = returns;
    const auto result = EstimateCurvature(BareCloud(Sphere(300'000, 1.0)), EstimatorOptions(), normals, pool);
    EXPECT_LE(result->cost.peak_bytes, 300'000 * EstimationBytesPerPoint(EstimatorOptions(), normals));
  }
}

TEST(EstimationJobTest, NormalsOfHalvesArePromised) {
  EstimatorOptions automatic = WithEstimator("auto"), jets = WithEstimator("jet");
  automatic.neighborhood = jets.neighborhood = AutomaticScale{};
  jets.jet_degree = 4;
  EXPECT_EQ(EstimationBytesPerPoint(automatic, Estimated()),
            EstimationBytesPerPoint(jets, Estimated()) + 12 + OutlierRun::kBytesPerPoint);
  EXPECT_EQ(EstimationBytesPerPoint(automatic), EstimationBytesPerPoint(jets) + 12 + OutlierRun::kBytesPerPoint)
      << "given ones may be fitted, too";
}

TEST(EstimationJobTest, CancelEndsTheJob) {
  WorkerPool pool(1);
  std::latch done(1);
  absl::Status status;
  EstimatorOptions options = WithEstimator("uniform");
  options.triangle_count = 10'000;  // minutes of work
  const auto job = EstimationJob::Start(Sphere(200'000, 1.0).ToCloud(), options, pool, JobPriority::kBatch,
                                        [&](absl::StatusOr<EstimationResult> result) {
                                          status = result.status();
                                          done.count_down();
                                        });
  job->Cancel();
  done.wait();
  EXPECT_EQ(status.code(), absl::StatusCode::kCancelled);
}

TEST(EstimationJobTest, CancelEndsTheJobWhileUmbrellasAreBuilt) {
  WorkerPool pool(1);
  std::latch started(1), done(2);
  std::shared_ptr<EstimationJob> job;
  // On the one thread blocks of both jobs take turns: this one comes after the two blocks that look at normals, and the
  // first ones of umbrellas.
  int turns = 0;
  pool.Submit(
      JobPriority::kBatch, 10'000,
      [&](size_t, int) {
        started.wait();
        if (job->progress().phase == JobPhase::kEstimating && ++turns > 4) job->Cancel();
      },
      [&] { done.count_down(); });
  absl::Status status;
  job = EstimationJob::Start(Sphere(50'000, 1.0).ToCloud(), WithEstimator("delaunay"), pool, JobPriority::kBatch,
                             [&](absl::StatusOr<EstimationResult> result) {
                               status = result.status();
                               done.count_down();
                             });
  started.count_down();
  done.wait();
  EXPECT_EQ(KindOf(status), ErrorKind::kCancelled);
  EXPECT_EQ(status.message(), "cancelled in the phase \"umbrellas\"");
  const JobProgress progress = job->progress();
  EXPECT_GT(progress.seconds.index, 0.0);
  EXPECT_GT(progress.seconds.estimate, 0.0);
  EXPECT_EQ(job->progress().seconds.estimate, progress.seconds.estimate);  // its time has stopped
}

TEST(EstimationJobTest, AJobThatIsCancelledInTheQueueHasNoOtherPhase) {
  WorkerPool pool(1);
  std::latch cancelled(1), done(2);
  pool.Submit(
      JobPriority::kBatch, 1, [&](size_t, int) { cancelled.wait(); }, [&] { done.count_down(); });
  const auto job = EstimationJob::Start(Sphere(100, 1.0).ToCloud(), EstimatorOptions(), pool, JobPriority::kBatch,
                                        [&](const absl::StatusOr<EstimationResult>& result) {
                                          EXPECT_TRUE(absl::IsCancelled(result.status()));
                                          done.count_down();
                                        });
  job->Cancel();
  cancelled.count_down();
  done.wait();
  EXPECT_GT(job->progress().seconds.queue, 0.0);
  EXPECT_FALSE(job->progress().seconds.index.has_value());
  EXPECT_FALSE(job->progress().seconds.estimate.has_value());
}

TEST(EstimationJobTest, ReportsTheUmbrellasAsPartOfTheEstimate) {
  for (std::string_view estimator : kEstimators) {
    const JobCost cost = MustEstimate(Sphere(20'000, 1.0).ToCloud(), WithEstimator(estimator)).cost;
    const double umbrella_seconds = SecondsOf(cost.phases, "umbrellas");
    EXPECT_EQ(umbrella_seconds > 0.0, estimator == "delaunay");
    EXPECT_LT(umbrella_seconds, cost.seconds.estimate);
  }
}

TEST(EstimationJobTest, RejectsOptionsOutOfRange) {
  EstimatorOptions options;
  options.neighborhood = NeighborCount{3};
  WorkerPool pool(1);
  const auto result = EstimateCurvature(Sphere(100, 1.0).ToCloud(), options, pool);
  EXPECT_EQ(result.status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(EstimationJobTest, PeakStaysBelowThePromise) {
  for (std::string_view estimator : {"avg-hexagram", "delaunay"}) {
    const EstimationResult result = MustEstimate(Sphere(500'000, 1.0).ToCloud(), WithEstimator(estimator));
    EXPECT_LE(result.cost.peak_bytes, 500'000 * EstimationBytesPerPoint(WithEstimator(estimator)));
  }
}

}  // namespace
}  // namespace curvd::testing
