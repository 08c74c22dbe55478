#include "core/scale/outliers/outlier_run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "core/job/worker_pool.h"
#include "tests/core/normals/normal_clouds.h"
#include "tests/core/scale/automatic_requests.h"
#include "tests/core/scale/outliers/outlier_clouds.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

EstimationResult EstimateOfPositions(const TestPoints& points) {
  WorkerPool pool(2);
  return *EstimateCurvature(BareCloud(points), Automatic(), Estimated(), pool);
}

TEST(OutlierRunTest, OutliersBesideNoisyPointsAreFound) {
  const TorusWithOutliers cloud = WithOutliersNearby(0.3, 300);
  const OutlierOutcome outcome = OutcomeOf(cloud, MustEstimate(cloud.points().ToCloud(), Automatic()));
  EXPECT_GE(outcome.found, 250u) << "the noise hides the nearest ones";
  EXPECT_EQ(outcome.mistaken, 0u);
  EXPECT_EQ(outcome.without_result, 0u);
  const double without = OutcomeOf(cloud, MustEstimate(cloud.WithInvalidOnes(), Automatic())).error;
  EXPECT_LT(outcome.error, 1.3 * without);
}

// Where each point has one of the outliers within reach, hardly any had a result.
TEST(OutlierRunTest, WrongNormalsOfOutliersTakeFewResults) {
  const TorusWithOutliers cloud = WithOutliersAnywhere(0.3, 100);
  const OutlierOutcome outcome = OutcomeOf(cloud, MustEstimate(cloud.points().ToCloud(), Automatic()));
  EXPECT_GE(outcome.found, 70u) << "the others lie within the noise";
  EXPECT_EQ(outcome.mistaken, 0u);
  EXPECT_LT(outcome.without_result, kTorusPoints / 50);
}

// Each outlier has neighbors with opposed normals, which refused two points in three: nobody was left to judge.
TEST(OutlierRunTest, OutliersAmongNoisyNormalsAreFound) {
  TorusWithOutliers cloud = WithOutliersAnywhere(0.1, 400);
  std::mt19937_64 random(17);
  std::normal_distribution<float> noise(0.0f, 0.2f);
  for (size_t i = 0; i < kTorusPoints; ++i) {
    for (float& component : cloud.points().normals[i]) component += noise(random);
  }
  const OutlierOutcome outcome = OutcomeOf(cloud, MustEstimate(cloud.points().ToCloud(), Automatic()));
  EXPECT_GE(outcome.found, 260u);
  EXPECT_EQ(outcome.mistaken, 0u);
  EXPECT_LT(outcome.without_result, kTorusPoints / 50);
}

// As where scans of one surface are merged. Copies bore each other out.
TEST(OutlierRunTest, CopiesOfOutliersAreOutliers) {
  TorusWithOutliers cloud = WithOutliersNearby(0.0, 100);
  for (int copy = 0; copy < 4; ++copy) {
    for (size_t i = kTorusPoints; i < kTorusPoints + 100; ++i) {
      const auto p = cloud.points().positions[i], n = cloud.points().normals[i];
      cloud.points().Add(p[0], p[1], p[2], n[0], n[1], n[2]);
    }
  }
  const OutlierOutcome outcome = OutcomeOf(cloud, MustEstimate(cloud.points().ToCloud(), Automatic()));
  EXPECT_GE(outcome.found, 450u) << "the others have those of another one beside them";
  EXPECT_EQ(outcome.mistaken, 0u);
}

// A right position with a normal that points to the other side.
TEST(OutlierRunTest, SingleFlippedNormalsAreOutliers) {
  TorusWithOutliers cloud = TorusWithoutOutliers(0.1);
  for (size_t i = 0; i < kTorusPoints; i += 200) {
    for (float& component : cloud.points().normals[i]) component = -component;
  }
  const EstimationResult result = MustEstimate(cloud.points().ToCloud(), Automatic());
  for (size_t i = 0; i < kTorusPoints; ++i) {
    const PointStatus expected = i % 200 == 0 ? PointStatus::kOutlier : PointStatus::kOk;
    ASSERT_EQ(result.field.points[i].status, expected) << i;
  }
}

TEST(OutlierRunTest, OutliersOfCloudsWithoutNormalsAreFound) {
  for (const double noise : {0.0, 0.3}) {
    const TorusWithOutliers cloud = WithOutliersNearby(noise, 200);
    const EstimationResult result = EstimateOfPositions(cloud.points());
    const OutlierOutcome outcome = OutcomeOf(cloud, result);
    EXPECT_GE(outcome.found, 190u) << noise;
    EXPECT_EQ(outcome.mistaken, 0u) << noise;
    EXPECT_EQ(outcome.without_result, 0u) << noise;
    TestPoints bare = cloud.points();
    bare.positions.resize(kTorusPoints);
    bare.normals.resize(kTorusPoints);
    const double without = OutcomeOf(TorusWithoutOutliers(noise), EstimateOfPositions(bare)).error;
    EXPECT_LT(outcome.error, 1.3 * without) << noise;
  }
}

// Of points beside exact ones, whose group has next to no noise.
TEST(OutlierRunTest, ANoisyTenthKeepsItsBorder) {
  TestPoints points = TorusWithoutOutliers(0.0).points();
  const TestPoints noisy = TorusWithoutOutliers(0.5).points();
  size_t of_part = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    if (points.positions[i][0] < 3.0f) continue;
    points.positions[i] = noisy.positions[i];
    ++of_part;
  }
  ASSERT_NEAR(static_cast<double>(of_part), 0.1 * kTorusPoints, 0.05 * kTorusPoints);
  EXPECT_LE(CountOutliers(MustEstimate(points.ToCloud(), Automatic())), of_part / 50);
}

TEST(OutlierRunTest, FarPointsAreOutliers) {
  for (const double far : {1e3, 1e12, 1e30, 1e37}) {
    TestPoints points = Waves(5'000, 0.0, 3);
    points.Add(far, 0.0, 0.0, 0.0, 0.0, 1.0);
    const EstimationResult result = MustEstimate(points.ToCloud(), Automatic());
    EXPECT_EQ(result.field.points[5'000].status, PointStatus::kOutlier) << far;
    EXPECT_EQ(CountOutliers(result), 1u) << far;
  }
}

// What is rare, and no outlier: edges and corners, noise, a noisy part, a sparse part. A few points of a rough terrain,
// and of edges with normals that were made of the positions, are off what their neighbors tell.
TEST(OutlierRunTest, SurfacesHaveHardlyAny) {
  constexpr size_t kMost = 6;
  std::vector<TestPoints> clouds = {TorusWithoutOutliers(0.0).points(),
                                    TorusWithoutOutliers(0.1).points(),
                                    TorusWithoutOutliers(1.0).points(),
                                    Waves(10'000, 0.0, 3),
                                    Waves(10'000, 0.003, 4),
                                    Pipe(5'000, 2),
                                    RoughTerrain(10'000, 3).points};
  TestPoints box;
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> part(-1.0, 1.0);
  for (size_t i = 0; i < 12'000; ++i) {
    std::array<double, 3> p = {part(random), part(random), part(random)}, n{};
    const size_t axis = i % 3;
    p[axis] = n[axis] = i % 2 == 0 ? 1.0 : -1.0;
    box.Add(p[0], p[1], p[2], n[0], n[1], n[2]);
  }
  clouds.push_back(box);
  TestPoints halves = TorusWithoutOutliers(0.0).points();
  const TestPoints noisy = TorusWithoutOutliers(1.0).points();
  for (size_t i = 0; i < halves.size(); ++i) {
    if (noisy.positions[i][0] > 0.0f) halves.positions[i] = noisy.positions[i];
  }
  clouds.push_back(halves);
  // A ball of which one half has a fiftieth of the other's points.
  TestPoints uneven;
  const TestPoints ball = Sphere(20'000, 1.0);
  for (size_t i = 0; i < ball.size(); ++i) {
    const auto p = ball.positions[i], n = ball.normals[i];
    if (p[2] > 0.0f || i % 50 == 0) uneven.Add(p[0], p[1], p[2], n[0], n[1], n[2]);
  }
  clouds.push_back(uneven);
  for (size_t i = 0; i < clouds.size(); ++i) {
    const bool is_rough = i == 6;
    EXPECT_LE(CountOutliers(MustEstimate(clouds[i].ToCloud(), Automatic())), is_rough ? kMost : 0) << i;
    const bool has_edges = i == 7;
    EXPECT_LE(CountOutliers(EstimateOfPositions(clouds[i])), is_rough || has_edges ? kMost : 0)
        << i << ", normals made";
  }
}

// A plane whose pieces lie in it, but for every `period`-th point, which lies off it, and has no result.
class PlaneWithOutliers {
 public:
  explicit PlaneWithOutliers(size_t period) {
    TestPoints points;
    for (size_t i = 0; i < kSide * kSide; ++i) {
      const bool is_outlier = i % period == 0;
      const double height = is_outlier ? 0.6 + static_cast<double>(i * 37 % 64) / 80.0 : 0.0;
      points.Add(static_cast<double>(i % kSide), static_cast<double>(i / kSide), height, 0.0, 0.0, 1.0);
      PointCurvature piece = UndefinedCurvature(is_outlier ? PointStatus::kSingularFit : PointStatus::kOk);
      if (!is_outlier) {
        piece.k1 = piece.k2 = 0.0f;
        piece.d1 = {1.0f, 0.0f, 0.0f};
        piece.d2 = {0.0f, 1.0f, 0.0f};
      }
      pieces_.push_back(piece);
      if (is_outlier) outliers_.push_back(static_cast<int32_t>(i));
    }
    index_ = BuildIndex(points.ToCloud());
  }

  std::vector<int32_t> Find() const {
    OutlierRun run(index_, pieces_.data(), true, OutlierSearch::kFirst);
    const auto scratch = run.MakeScratch();
    for (const GroupPhase& phase : run.Phases()) {
      if (!phase.Begin().value()) continue;
      for (size_t group = 0; group < index_.group_count(); ++group) EXPECT_TRUE(phase.run(group, *scratch).ok());
    }
    std::vector<int32_t> found = run.TakeOutliers();
    std::sort(found.begin(), found.end());
    return found;
  }
  const std::vector<int32_t>& outliers() const { return outliers_; }

 private:
  static constexpr size_t kSide = 64;
  SpatialIndex index_;
  std::vector<PointCurvature> pieces_;
  std::vector<int32_t> outliers_;
};

TEST(OutlierRunTest, FindsWhatNoPieceComesNearTo) {
  const PlaneWithOutliers plane(10);
  EXPECT_EQ(plane.Find(), plane.outliers());
}

// A third of all is no exception.
TEST(OutlierRunTest, ManyPointsOffTheSurfaceAreNoOutliers) { EXPECT_TRUE(PlaneWithOutliers(3).Find().empty()); }

}  // namespace
}  // namespace curvd::testing
