#include "core/scale/outliers/outlier_run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <latch>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/job/worker_pool.h"
#include "tests/core/normals/normal_clouds.h"
#include "tests/core/scale/automatic_requests.h"
#include "tests/core/test_clouds.h"
#include "tests/core/true_clouds.h"

namespace curvd::testing {
namespace {

// The spacing of 10,000 points of a torus of radii 3 and 1.
constexpr double kTorusSpacing = 0.109;
constexpr size_t kTorusPoints = 10'000;

// A torus, and points that lie off it at the end of the cloud.
struct TorusWithOutliers {
  TruePoints torus;
  size_t outliers = 0;
  TestPoints& points() { return torus.points; }
  const TestPoints& points() const { return torus.points; }

  bool IsOutlier(size_t i) const { return i >= kTorusPoints; }
  // The same with the outliers as invalid points.
  Cloud WithInvalidOnes() const {
    TestPoints without = points();
    for (size_t i = kTorusPoints; i < without.size(); ++i) {
      without.positions[i][0] = std::numeric_limits<float>::quiet_NaN();
    }
    return without.ToCloud();
  }
};

TorusWithOutliers TorusWithNoise(double noise) {
  TorusWithOutliers cloud{TrueTorus(kTorusPoints, 5)};
  AddNoise(noise * kTorusSpacing, 7, cloud.points());
  return cloud;
}

// Outliers at 2 to 10 spacings from the surface, with about its normal.
TorusWithOutliers WithOutliersNearby(double noise, size_t outliers) {
  TorusWithOutliers cloud = TorusWithNoise(noise);
  cloud.outliers = outliers;
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> spacings(2.0, 10.0);
  for (size_t j = 0; j < outliers; ++j) {
    const size_t i = random() % kTorusPoints;
    const auto p = cloud.points().positions[i], n = cloud.points().normals[i];
    const double off = (j % 2 == 0 ? 1.0 : -1.0) * spacings(random) * kTorusSpacing;
    cloud.points().Add(p[0] + off * n[0], p[1] + off * n[1], p[2] + off * n[2], n[0], n[1], n[2]);
  }
  return cloud;
}

// Outliers anywhere in the box of the torus, with any normal.
TorusWithOutliers WithOutliersAnywhere(double noise, size_t outliers) {
  TorusWithOutliers cloud = TorusWithNoise(noise);
  cloud.outliers = outliers;
  std::mt19937_64 random(13);
  std::uniform_real_distribution<double> part(-1.0, 1.0);
  std::normal_distribution<double> normal;
  for (size_t j = 0; j < outliers; ++j) {
    cloud.points().Add(4.4 * part(random), 4.4 * part(random), 1.2 * part(random), normal(random), normal(random),
                       normal(random));
  }
  return cloud;
}

// What became of the points of the surface, and of the outliers.
struct Outcome {
  size_t found = 0, mistaken = 0, without_result = 0;
  double error = 0.0;  // mean |H error| of the points of the surface that have a result
};

Outcome OutcomeOf(const TorusWithOutliers& cloud, const EstimationResult& result) {
  Outcome outcome;
  size_t estimated = 0;
  for (size_t i = 0; i < cloud.points().size(); ++i) {
    const PointCurvature& point = result.field.points[i];
    const bool is_called_one = point.status == PointStatus::kOutlier;
    if (cloud.IsOutlier(i)) {
      outcome.found += is_called_one ? 1 : 0;
      continue;
    }
    outcome.mistaken += is_called_one ? 1 : 0;
    outcome.without_result += point.status == PointStatus::kOk ? 0 : 1;
    if (point.status != PointStatus::kOk) continue;
    outcome.error += std::abs(point.mean - cloud.torus.mean[i]);
    ++estimated;
  }
  outcome.error /= static_cast<double>(estimated);
  return outcome;
}

size_t CountOutliers(const EstimationResult& result) {
  return result.field.status_counts[static_cast<size_t>(PointStatus::kOutlier)];
}

EstimationResult EstimateOfPositions(const TestPoints& points) {
  WorkerPool pool(2);
  return *EstimateCurvature(BareCloud(points), Automatic(), Estimated(), pool);
}

// What a cloud has in which the same points are invalid; normals are rounded once more.
TEST(OutlierRunTest, OutliersBesideExactPointsAreNobodysNeighbors) {
  const TorusWithOutliers cloud = WithOutliersNearby(0.0, 300);
  const EstimationResult result = MustEstimate(cloud.points().ToCloud(), Automatic());
  const Outcome outcome = OutcomeOf(cloud, result);
  EXPECT_EQ(outcome.found, 300u);
  EXPECT_EQ(outcome.mistaken, 0u);
  EXPECT_EQ(CountOutliers(result), 300u);
  EXPECT_EQ(result.field.status_counts[static_cast<size_t>(PointStatus::kInvalidInput)], 0u);
  EXPECT_EQ(result.field.status_counts[static_cast<size_t>(PointStatus::kOk)], kTorusPoints);
  const EstimationResult without = MustEstimate(cloud.WithInvalidOnes(), Automatic());
  for (size_t i = 0; i < kTorusPoints; ++i) {
    ASSERT_NEAR(result.field.points[i].mean, without.field.points[i].mean, 1e-5) << i;
  }
  for (size_t i = kTorusPoints; i < cloud.points().size(); ++i) {
    const PointCurvature& point = result.field.points[i];
    EXPECT_TRUE(std::isnan(point.mean) && std::isnan(point.k1) && std::isnan(point.d1[0]) && std::isnan(point.radius));
  }
}

TEST(OutlierRunTest, OutliersBesideNoisyPointsAreFound) {
  const TorusWithOutliers cloud = WithOutliersNearby(0.3, 300);
  const Outcome outcome = OutcomeOf(cloud, MustEstimate(cloud.points().ToCloud(), Automatic()));
  EXPECT_GE(outcome.found, 250u) << "the noise hides the nearest ones";
  EXPECT_EQ(outcome.mistaken, 0u);
  EXPECT_EQ(outcome.without_result, 0u);
  const double without = OutcomeOf(cloud, MustEstimate(cloud.WithInvalidOnes(), Automatic())).error;
  EXPECT_LT(outcome.error, 1.3 * without);
}

// Where each point has one of the outliers within reach, hardly any had a result.
TEST(OutlierRunTest, WrongNormalsOfOutliersTakeFewResults) {
  const TorusWithOutliers cloud = WithOutliersAnywhere(0.3, 100);
  const Outcome outcome = OutcomeOf(cloud, MustEstimate(cloud.points().ToCloud(), Automatic()));
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
  const Outcome outcome = OutcomeOf(cloud, MustEstimate(cloud.points().ToCloud(), Automatic()));
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
  const Outcome outcome = OutcomeOf(cloud, MustEstimate(cloud.points().ToCloud(), Automatic()));
  EXPECT_GE(outcome.found, 450u) << "the others have those of another one beside them";
  EXPECT_EQ(outcome.mistaken, 0u);
}

// What an outlier's normal is opposed to is no seam.
TEST(OutlierRunTest, SeamsAreRejectedWithoutOutliers) {
  EstimatorOptions rejects = Automatic();
  rejects.opposed_normals = OpposedNormalsPolicy::kReject;
  TestPoints points = TorusWithNoise(0.1).points();
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
TEST(OutlierRunTest, TurnedNormalsAreThoseThatTheCallerSent) {
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
}

// A right position with a normal that points to the other side.
TEST(OutlierRunTest, SingleFlippedNormalsAreOutliers) {
  TorusWithOutliers cloud = TorusWithNoise(0.1);
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
    const Outcome outcome = OutcomeOf(cloud, result);
    EXPECT_GE(outcome.found, 190u) << noise;
    EXPECT_EQ(outcome.mistaken, 0u) << noise;
    EXPECT_EQ(outcome.without_result, 0u) << noise;
    TestPoints bare = cloud.points();
    bare.positions.resize(kTorusPoints);
    bare.normals.resize(kTorusPoints);
    const double without = OutcomeOf(TorusWithNoise(noise), EstimateOfPositions(bare)).error;
    EXPECT_LT(outcome.error, 1.3 * without) << noise;
  }
}

TEST(OutlierRunTest, NormalsThatAreReturnedSayWhoIsAnOutlier) {
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

// Of points beside exact ones, whose group has next to no noise.
TEST(OutlierRunTest, ANoisyTenthKeepsItsBorder) {
  TestPoints points = TorusWithNoise(0.0).points();
  const TestPoints noisy = TorusWithNoise(0.5).points();
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
  std::vector<TestPoints> clouds = {TorusWithNoise(0.0).points(),  TorusWithNoise(0.1).points(),
                                    TorusWithNoise(1.0).points(),  Waves(10'000, 0.0, 3),
                                    Waves(10'000, 0.003, 4),       Pipe(5'000, 2),
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
  TestPoints halves = TorusWithNoise(0.0).points();
  const TestPoints noisy = TorusWithNoise(1.0).points();
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
      EXPECT_TRUE(phase.begin == nullptr || phase.begin().ok());
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

TEST(OutlierRunTest, OnlyAChoiceOfBothLooksForThem) {
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

TEST(OutlierRunTest, NeitherThreadsNorUnitsMatter) {
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
TEST(OutlierRunTest, ALargeCloudKeepsItsPoints) {
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

TEST(OutlierRunTest, TheCostIsThatOfAllPasses) {
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
TEST(OutlierRunTest, TheSecondPassCanBeCancelled) {
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
