#include "server/admission/admission.h"

#include <gtest/gtest.h>

#include "core/estimators/delaunay/umbrella.h"
#include "core/job/job_memory.h"
#include "core/job/phases/normal_phases.h"
#include "core/job/phases/normal_tasks.h"
#include "server/rpc/error_reasons.h"
#include "tests/server/status_matchers.h"

namespace curvd {
namespace {

constexpr uint64_t kMiB = 1 << 20;
constexpr int kThreads = 2;
const EstimatorOptions kHexagram;

EstimatorOptions Delaunay() {
  EstimatorOptions options;
  options.estimator = "delaunay";
  return options;
}

CallOptions Call(const EstimatorOptions& estimator, uint64_t point_count = 1'000'000) {
  CallOptions options;
  options.point_count = point_count;
  options.estimator = estimator;
  return options;
}

void MustNotBeAnswered(const absl::Status& status) { FAIL() << "unexpected answer: " << status; }

TEST(AdmissionTest, ReservesForEveryPointAndForMessagesInFlight) {
  const Admission admission(1024 * kMiB, 4 * kMiB, 10, kThreads);
  const uint64_t million = admission.CallBytes(1'000'000, Call(kHexagram), false);
  EXPECT_GE(million, 1'000'000 * EstimationBytesPerPoint(kHexagram) + 4 * kMiB);
  EXPECT_LE(million, 1'000'000 * EstimationBytesPerPoint(kHexagram) + 20 * kMiB);
  EXPECT_LT(admission.SendingBytes(1'000'000, Call(kHexagram)), million);
}

TEST(AdmissionTest, ReservesForTheUmbrellasOfEveryPoint) {
  const Admission admission(1024 * kMiB, 4 * kMiB, 10, kThreads);
  const uint64_t hexagram = admission.CallBytes(1'000'000, Call(kHexagram), false);
  const uint64_t delaunay = admission.CallBytes(1'000'000, Call(Delaunay()), false);
  const uint64_t scratch =
      EstimationScratchBytes(Delaunay(), 1'000'000, kThreads) - EstimationScratchBytes(kHexagram, 1'000'000, kThreads);
  EXPECT_EQ(delaunay - hexagram, 1'000'000 * sizeof(Umbrella) + scratch);
}

TEST(AdmissionTest, ReservesScratchForEachWorkerThatHasABlock) {
  const Admission one(1024 * kMiB, 4 * kMiB, 10, 1), eight(1024 * kMiB, 4 * kMiB, 10, 8);
  const auto difference = [&](uint64_t points, const EstimatorOptions& options) {
    return eight.CallBytes(points, Call(options), false) - one.CallBytes(points, Call(options), false);
  };
  EXPECT_EQ(difference(1'000, kHexagram), 0u);
  const auto scratch = [](int threads) { return EstimationScratchBytes(kHexagram, 1'000'000, threads); };
  EXPECT_EQ(difference(1'000'000, kHexagram), scratch(8) - scratch(1));
  EXPECT_EQ(scratch(16), 2 * scratch(8)) << "two workers at most look at normals";
  EstimatorOptions by_radius;
  by_radius.neighborhood = NeighborRadius{1.0};
  EXPECT_GT(difference(1'000'000, by_radius), 7 * kMiB) << "a radius may reach max_neighbor_count points";
}

TEST(AdmissionTest, ReservesForNormalsAndTheirOrientation) {
  const Admission admission(4096 * kMiB, 4 * kMiB, 10, kThreads);
  CallOptions options = Call(kHexagram);
  const uint64_t given = admission.CallBytes(1'000'000, options, false);
  options.normals.source = NormalSource::kEstimate;
  const uint64_t estimated = admission.CallBytes(1'000'000, options, false);
  EXPECT_GE(estimated - given, 1'000'000 * NormalBytesPerPoint(options.normals, NormalTasks()) - 4 * kMiB)
      << "chunks have no normals";
  options.normals.returns_normals = true;
  options.quantities.Add(curvature::v1::QUANTITY_NORMALS);
  EXPECT_GE(admission.CallBytes(1'000'000, options, false), estimated + 1'000'000 * sizeof(PointNormal));
  EXPECT_EQ(admission.SendingBytes(1'000'000, options) / 1'000'000, sizeof(PointNormal) + sizeof(PointCurvature) + 1)
      << "and messages";
}

TEST(AdmissionTest, ReservesNothingForCurvatureWhereNormalsAloneAreWanted) {
  const Admission admission(4096 * kMiB, 4 * kMiB, 10, kThreads);
  CallOptions options = Call(kHexagram);
  options.normals.source = NormalSource::kEstimate;
  options.normals.returns_normals = true;
  options.quantities.Add(curvature::v1::QUANTITY_NORMALS);
  const uint64_t both = admission.CallBytes(1'000'000, options, false);
  options.quantities = QuantitySet::None();
  options.quantities.Add(curvature::v1::QUANTITY_NORMALS);
  EXPECT_LE(admission.CallBytes(1'000'000, options, false), both - 1'000'000 * sizeof(PointCurvature));
}

TEST(AdmissionTest, ReservesForTheViewpointsOfPoints) {
  const Admission admission(4096 * kMiB, 4 * kMiB, 10, kThreads);
  CallOptions one = Call(kHexagram);
  one.normals.source = NormalSource::kEstimate;
  one.normals.sides = SidesTowardViewpoint{{0.0, 0.0, 0.0}};
  CallOptions each = one;
  each.normals.sides = SidesTowardViewpoints{};
  EXPECT_GE(admission.CallBytes(1'000'000, each, false) - admission.CallBytes(1'000'000, one, false),
            1'000'000 * 3 * sizeof(double));
  CallOptions unknown = each;
  unknown.point_count = 0;
  EXPECT_GE(admission.CallBytes(1'000'000, unknown, false) - admission.CallBytes(1'000'000, each, false),
            2 * 1'000'000 * 3 * sizeof(double))
      << "an array that grows is there twice";
}

TEST(AdmissionTest, ReservesForChoicesAndTheDirectionsOfPoints) {
  const Admission admission(4096 * kMiB, 4 * kMiB, 10, kThreads);
  CallOptions plain = Call(kHexagram), sure = plain, toward = plain;
  plain.estimator.estimator = sure.estimator.estimator = kAutomaticEstimator;
  sure.estimator.returns_choice = true;
  sure.quantities.Add(curvature::v1::QUANTITY_STANDARD_ERRORS);
  EXPECT_GE(admission.CallBytes(1'000'000, sure, false) - admission.CallBytes(1'000'000, plain, false),
            1'000'000 * sizeof(PointChoice));
  EXPECT_GE(admission.SendingBytes(1'000'000, sure) - admission.SendingBytes(1'000'000, plain),
            1'000'000 * sizeof(PointChoice));
  plain = toward;
  toward.quantities.Add(curvature::v1::QUANTITY_NORMAL_CURVATURE);
  ASSERT_TRUE(toward.has_directions());
  EXPECT_GE(admission.CallBytes(1'000'000, toward, false) - admission.CallBytes(1'000'000, plain, false),
            1'000'000 * sizeof(Direction));
  EXPECT_GE(admission.SendingBytes(1'000'000, toward) - admission.SendingBytes(1'000'000, plain),
            1'000'000 * sizeof(Direction));
}

TEST(AdmissionTest, AnOrdinaryCallFitsASmallServer) {
  Admission admission(256 * kMiB, 4 * kMiB, 10, 8);
  EXPECT_TRUE(admission.Enter(Call(kHexagram, 500'000), 0).ok());
  EXPECT_TRUE(admission.Enter(Call(kHexagram, 0), 0).ok());
}

TEST(AdmissionTest, ReservesLittleForLittleClouds) {
  const Admission admission(1024 * kMiB, 4 * kMiB, 10, kThreads);
  CallOptions doubles = Call(kHexagram);
  doubles.scalar_type = ScalarType::kFloat64;
  EXPECT_LT(admission.CallBytes(1, doubles, false), 192u << 10);
  EXPECT_GT(admission.CallBytes(1, doubles, true), 4 * kMiB) << "a large chunk may follow";
}

TEST(AdmissionTest, RefusesACloudThatCouldNeverFit) {
  Admission admission(64 * kMiB, 4 * kMiB, 10, kThreads);
  EXPECT_TRUE(IsError(admission.Enter(Call(kHexagram, 10'000'000), 0).status(), absl::StatusCode::kResourceExhausted,
                      kReasonMemoryLimit, {"header.point_count", "10000000", absl::StrCat(56 * kMiB), "memory_limit"}));
}

TEST(AdmissionTest, TellsWhichPartOfTheMemoryACallMayHave) {
  Admission admission(64 * kMiB, 4 * kMiB, 10, kThreads);
  const auto reservation = admission.Enter(Call(kHexagram, 0), 0);
  ASSERT_TRUE(reservation.ok()) << reservation.status();
  const auto grown = (*reservation)->GrowTo(57 * kMiB, [](const absl::Status&) {});
  EXPECT_TRUE(IsError(grown.status(), absl::StatusCode::kResourceExhausted, kReasonMemoryLimit,
                      {absl::StrCat("at most ", 56 * kMiB, " bytes (7/8 of memory_limit)")}));
}

TEST(AdmissionTest, SmallCallsDoNotWaitForLargeOnes) {
  Admission admission(1024 * kMiB, 4 * kMiB, 10, kThreads);
  auto large = admission.Enter(Call(kHexagram, 8'000'000), 0);
  auto second = admission.Enter(Call(kHexagram, 8'000'000), 0);
  auto small = admission.Enter(Call(kHexagram, 10'000), 0);
  ASSERT_TRUE(large.ok() && second.ok() && small.ok());
  const uint64_t bytes = admission.CallBytes(8'000'000, Call(kHexagram), false);
  EXPECT_TRUE(*(*large)->GrowTo(bytes, MustNotBeAnswered));
  EXPECT_FALSE(*(*second)->GrowTo(bytes, [](const absl::Status&) {}));
  EXPECT_EQ(admission.waiting(), 1u);
  const uint64_t small_bytes = admission.CallBytes(10'000, Call(kHexagram), false);
  EXPECT_TRUE(*(*small)->GrowTo(small_bytes, MustNotBeAnswered));
  EXPECT_EQ(admission.reserved(), bytes + small_bytes);
  EXPECT_EQ(admission.limit(), 1024 * kMiB);
}

}  // namespace
}  // namespace curvd
