#include "server/admission/admission.h"

#include <gtest/gtest.h>

#include "core/estimators/delaunay/umbrella.h"
#include "core/job/estimation_job.h"
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

void MustNotBeAnswered(const absl::Status& status) { FAIL() << "unexpected answer: " << status; }

TEST(AdmissionTest, ReservesForEveryPointAndForMessagesInFlight) {
  const Admission admission(1024 * kMiB, 4 * kMiB, 10, kThreads);
  const uint64_t million = admission.CallBytes(1'000'000, ScalarType::kFloat32, kHexagram, false);
  EXPECT_GE(million, 1'000'000 * EstimationBytesPerPoint(kHexagram) + 4 * kMiB);
  EXPECT_LE(million, 1'000'000 * EstimationBytesPerPoint(kHexagram) + 20 * kMiB);
  EXPECT_LT(admission.SendingBytes(1'000'000), million);
}

TEST(AdmissionTest, ReservesForTheUmbrellasOfEveryPoint) {
  const Admission admission(1024 * kMiB, 4 * kMiB, 10, kThreads);
  const uint64_t hexagram = admission.CallBytes(1'000'000, ScalarType::kFloat32, kHexagram, false);
  const uint64_t delaunay = admission.CallBytes(1'000'000, ScalarType::kFloat32, Delaunay(), false);
  const uint64_t scratch =
      EstimationScratchBytes(Delaunay(), 1'000'000, kThreads) - EstimationScratchBytes(kHexagram, 1'000'000, kThreads);
  EXPECT_EQ(delaunay - hexagram, 1'000'000 * sizeof(Umbrella) + scratch);
}

TEST(AdmissionTest, ReservesScratchForEachWorkerThatHasABlock) {
  const Admission one(1024 * kMiB, 4 * kMiB, 10, 1), eight(1024 * kMiB, 4 * kMiB, 10, 8);
  const auto difference = [&](uint64_t points, const EstimatorOptions& options) {
    return eight.CallBytes(points, ScalarType::kFloat32, options, false) -
           one.CallBytes(points, ScalarType::kFloat32, options, false);
  };
  EXPECT_EQ(difference(1'000, kHexagram), 0u);
  EXPECT_EQ(difference(1'000'000, kHexagram), 7 * EstimationScratchBytes(kHexagram, 1'000'000, 1));
  EstimatorOptions by_radius;
  by_radius.neighborhood = NeighborRadius{1.0};
  EXPECT_GT(difference(1'000'000, by_radius), 7 * kMiB) << "a radius may reach max_neighbor_count points";
}

TEST(AdmissionTest, AnOrdinaryCallFitsASmallServer) {
  Admission admission(256 * kMiB, 4 * kMiB, 10, 8);
  EXPECT_TRUE(admission.Enter(500'000, ScalarType::kFloat32, kHexagram, 0).ok());
  EXPECT_TRUE(admission.Enter(0, ScalarType::kFloat32, kHexagram, 0).ok());
}

TEST(AdmissionTest, ReservesLittleForLittleClouds) {
  const Admission admission(1024 * kMiB, 4 * kMiB, 10, kThreads);
  EXPECT_LT(admission.CallBytes(1, ScalarType::kFloat64, kHexagram, false), 192u << 10);
  EXPECT_GT(admission.CallBytes(1, ScalarType::kFloat64, kHexagram, true), 4 * kMiB) << "a large chunk may follow";
}

TEST(AdmissionTest, RefusesACloudThatCouldNeverFit) {
  Admission admission(64 * kMiB, 4 * kMiB, 10, kThreads);
  EXPECT_TRUE(IsError(admission.Enter(10'000'000, ScalarType::kFloat32, kHexagram, 0).status(),
                      absl::StatusCode::kResourceExhausted, kReasonMemoryLimit,
                      {"header.point_count", "10000000", absl::StrCat(56 * kMiB), "memory_limit"}));
}

TEST(AdmissionTest, SmallCallsDoNotWaitForLargeOnes) {
  Admission admission(1024 * kMiB, 4 * kMiB, 10, kThreads);
  auto large = admission.Enter(8'000'000, ScalarType::kFloat32, kHexagram, 0);
  auto second = admission.Enter(8'000'000, ScalarType::kFloat32, kHexagram, 0);
  auto small = admission.Enter(10'000, ScalarType::kFloat32, kHexagram, 0);
  ASSERT_TRUE(large.ok() && second.ok() && small.ok());
  const uint64_t bytes = admission.CallBytes(8'000'000, ScalarType::kFloat32, kHexagram, false);
  EXPECT_TRUE(*(*large)->GrowTo(bytes, MustNotBeAnswered));
  EXPECT_FALSE(*(*second)->GrowTo(bytes, [](const absl::Status&) {}));
  EXPECT_EQ(admission.waiting(), 1u);
  const uint64_t small_bytes = admission.CallBytes(10'000, ScalarType::kFloat32, kHexagram, false);
  EXPECT_TRUE(*(*small)->GrowTo(small_bytes, MustNotBeAnswered));
  EXPECT_EQ(admission.reserved(), bytes + small_bytes);
  EXPECT_EQ(admission.limit(), 1024 * kMiB);
}

}  // namespace
}  // namespace curvd
