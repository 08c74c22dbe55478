#include "server/call/scale/wire_scale.h"

#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>
#include <limits>
#include <string>

#include "absl/strings/str_cat.h"
#include "core/estimators/scale_ladder.h"
#include "core/estimators/strategies.h"
#include "server/call/header_options.h"
#include "server/rpc/error_reasons.h"
#include "tests/server/status_matchers.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;

CallLimits LimitsOf(uint32_t max_neighbor_count) { return {1000, 4096, max_neighbor_count, 1 << 30, 10}; }

// As a header resolves that asks for those counts.
absl::StatusOr<CallOptions> ResolveScale(const v1::EstimatorOptions& options, uint32_t max_neighbor_count = 10'000) {
  v1::CloudHeader header;
  *header.mutable_options() = options;
  return ResolveHeader(header, LimitsOf(max_neighbor_count));
}

AutomaticScale ScaleOf(const v1::EstimatorOptions& options, uint32_t max_neighbor_count = 10'000) {
  const auto resolved = ResolveScale(options, max_neighbor_count);
  EXPECT_TRUE(resolved.ok()) << resolved.status();
  return resolved.ok() ? std::get<AutomaticScale>(resolved->estimator.neighborhood) : AutomaticScale{1, 1, -1.0};
}

::testing::AssertionResult IsRefused(const v1::EstimatorOptions& options, const std::string& field,
                                     std::initializer_list<std::string> words) {
  const auto resolved = ResolveScale(options);
  if (resolved.ok()) return ::testing::AssertionFailure() << options.ShortDebugString() << " is taken";
  if (resolved.status().message().find("header.options." + field + " is ") == std::string::npos) {
    return ::testing::AssertionFailure() << resolved.status() << " does not name " << field;
  }
  return IsError(resolved.status(), absl::StatusCode::kInvalidArgument, kReasonInvalidOption, words);
}

v1::EstimatorOptions Asking(v1::Estimator estimator, uint32_t least = 0, uint32_t most = 0) {
  v1::EstimatorOptions options;
  options.set_estimator(estimator);
  options.mutable_automatic_scale()->set_least_neighbor_count(least);
  options.mutable_automatic_scale()->set_most_neighbor_count(most);
  return options;
}

TEST(ReadScaleTest, AutoAloneLeavesTheScaleOpenToo) {
  v1::EstimatorOptions options;
  options.set_estimator(v1::ESTIMATOR_AUTO);
  const auto resolved = ResolveScale(options);
  ASSERT_TRUE(resolved.ok()) << resolved.status();
  EXPECT_EQ(resolved->estimator.estimator, kAutomaticEstimator);
  const AutomaticScale scale = ScaleOf(options);
  EXPECT_EQ(scale.least_count, 16u);
  EXPECT_EQ(scale.most_count, 2048u);
  EXPECT_EQ(scale.max_radius, 0.0);
  EXPECT_FALSE(scale.per_cloud);
}

TEST(ReadScaleTest, TakesEveryFieldAsGiven) {
  v1::EstimatorOptions options = Asking(v1::ESTIMATOR_AVG_HEXAGRAM, 32, 512);
  options.mutable_automatic_scale()->set_max_radius(0.25);
  options.mutable_automatic_scale()->set_per_cloud(true);
  const AutomaticScale scale = ScaleOf(options);
  EXPECT_EQ(scale.least_count, 32u);
  EXPECT_EQ(scale.most_count, 512u);
  EXPECT_EQ(scale.max_radius, 0.25);
  EXPECT_TRUE(scale.per_cloud);
  EXPECT_EQ(ResolveScale(options)->estimator.estimator, "avg-hexagram");
}

TEST(ReadScaleTest, AutoTakesACountThatIsFixed) {
  v1::EstimatorOptions options;
  options.set_estimator(v1::ESTIMATOR_AUTO);
  options.set_neighbor_count(100);
  const auto resolved = ResolveScale(options);
  ASSERT_TRUE(resolved.ok()) << resolved.status();
  EXPECT_EQ(std::get<NeighborCount>(resolved->estimator.neighborhood).count, 100u);
}

TEST(ReadScaleTest, CountsHaveBounds) {
  EXPECT_EQ(ScaleOf(Asking(v1::ESTIMATOR_AUTO, 16, 16)).most_count, 16u);
  EXPECT_EQ(ScaleOf(Asking(v1::ESTIMATOR_AUTO, 2048, 2048)).least_count, 2048u);
  const std::string least = "automatic_scale.least_neighbor_count", most = "automatic_scale.most_neighbor_count";
  EXPECT_TRUE(IsRefused(Asking(v1::ESTIMATOR_AUTO, 15), least, {"is 15; it must be from 16 to 2048"}));
  EXPECT_TRUE(
      IsRefused(Asking(v1::ESTIMATOR_AUTO, 65, 64), least, {"is 65; it must be from 16 to 64 (most_neighbor_count)"}));
  EXPECT_TRUE(IsRefused(Asking(v1::ESTIMATOR_AUTO, 0, 15), most, {"is 15", "from 16 to 2048"}));
  EXPECT_TRUE(IsRefused(Asking(v1::ESTIMATOR_AUTO, 0, 2049), most, {"is 2049", "from 16 to 2048"}));
}

TEST(ReadScaleTest, TheServersLimitHolds) {
  EXPECT_EQ(ScaleOf(Asking(v1::ESTIMATOR_AUTO), 100).most_count, 100u) << "the default heeds it";
  EXPECT_EQ(ScaleOf(Asking(v1::ESTIMATOR_AUTO, 0, 100), 100).most_count, 100u);
  const auto refusal = [](const v1::EstimatorOptions& options, uint32_t limit) {
    return ResolveScale(options, limit).status();
  };
  EXPECT_TRUE(IsError(refusal(Asking(v1::ESTIMATOR_AUTO, 0, 101), 100), absl::StatusCode::kResourceExhausted,
                      kReasonNeighborhoodTooLarge,
                      {"automatic_scale.most_neighbor_count is 101", "at most 100 (max_neighbor_count)"}));
  EXPECT_TRUE(IsError(refusal(Asking(v1::ESTIMATOR_AUTO), 15), absl::StatusCode::kResourceExhausted,
                      kReasonNeighborhoodTooLarge, {"is 16", "at most 15 (max_neighbor_count)"}));
  EXPECT_TRUE(IsError(refusal(Asking(v1::ESTIMATOR_AUTO, 101), 100), absl::StatusCode::kInvalidArgument,
                      kReasonInvalidOption,
                      {"least_neighbor_count is 101; it must be from 16 to 100 (max_neighbor_count)"}));
}

TEST(ReadScaleTest, RefusalsNameABoundThatThisServerTakes) {
  EXPECT_TRUE(IsError(ResolveScale(Asking(v1::ESTIMATOR_AUTO, 0, 2049), 100).status(),
                      absl::StatusCode::kInvalidArgument, kReasonInvalidOption,
                      {"most_neighbor_count is 2049; it must be from 16 to 100"}));
}

TEST(ReadScaleTest, RadiiThatAreNoBoundAreRefused) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double radius : {-1.0, -1e-300, kInfinity, -kInfinity, std::nan("")}) {
    v1::EstimatorOptions options = Asking(v1::ESTIMATOR_AUTO);
    options.mutable_automatic_scale()->set_max_radius(radius);
    EXPECT_TRUE(IsRefused(options, "automatic_scale.max_radius", {"finite, and 0 or more"})) << radius;
  }
  for (const double radius : {0.0, -0.0, 5e-324, 1e308}) {
    v1::EstimatorOptions options = Asking(v1::ESTIMATOR_AUTO);
    options.mutable_automatic_scale()->set_max_radius(radius);
    EXPECT_EQ(ScaleOf(options).max_radius, radius);
  }
}

TEST(CheckChoiceTest, JetsAreOfTheDegreeThatTheChoiceKnows) {
  v1::EstimatorOptions jet = Asking(v1::ESTIMATOR_JET_FITTING);
  EXPECT_EQ(ResolveScale(jet)->estimator.jet_degree, 4u) << "the default";
  jet.set_jet_degree(4);
  EXPECT_TRUE(ResolveScale(jet).ok());
  for (const uint32_t degree : {2u, 3u}) {
    jet.set_jet_degree(degree);
    EXPECT_TRUE(IsRefused(jet, "jet_degree", {absl::StrCat("is ", degree), "4 where automatic_scale is set"}));
  }
  v1::EstimatorOptions fixed;
  fixed.set_estimator(v1::ESTIMATOR_JET_FITTING);
  EXPECT_EQ(ResolveScale(fixed)->estimator.jet_degree, 2u) << "with a count, the default stays what it was";
}

TEST(CheckChoiceTest, EstimatorsThatTheChoiceDoesNotKnowAreRefused) {
  for (const v1::Estimator unknown :
       {v1::ESTIMATOR_HEXAGRAM, v1::ESTIMATOR_UNIFORM, v1::ESTIMATOR_INDEPENDENT, v1::ESTIMATOR_DELAUNAY}) {
    EXPECT_TRUE(
        IsRefused(Asking(unknown), "estimator", {"auto, avg-hexagram", "jet or aso where automatic_scale is set"}));
  }
  for (const v1::Estimator known : {v1::ESTIMATOR_UNSPECIFIED, v1::ESTIMATOR_AVG_HEXAGRAM, v1::ESTIMATOR_JET_FITTING,
                                    v1::ESTIMATOR_ALGEBRAIC_SHAPE_OPERATOR}) {
    EXPECT_TRUE(ResolveScale(Asking(known)).ok()) << known;
  }
}

TEST(CheckChoiceTest, EveryEstimatorThatIsOfferedExistsAndIsTaken) {
  const std::string message(ResolveScale(Asking(v1::ESTIMATOR_DELAUNAY)).status().message());
  for (const ScaleMethod& method : kScaleMethods) {
    const bool is_named = message.find(std::string(method.estimator)) != std::string::npos;
    EXPECT_EQ(is_named, FindStrategy(method.estimator) != nullptr) << method.estimator << " in: " << message;
  }
}

TEST(CheckChoiceTest, AnAutomaticScaleProjectsTheAlgebraicShapeOperator) {
  EXPECT_TRUE(ResolveScale(Asking(v1::ESTIMATOR_ALGEBRAIC_SHAPE_OPERATOR))->estimator.project);
  EXPECT_FALSE(ResolveScale(Asking(v1::ESTIMATOR_AVG_HEXAGRAM))->estimator.project);
}

TEST(CheckChoiceTest, AutoTakesNoRadius) {
  v1::EstimatorOptions options;
  options.set_estimator(v1::ESTIMATOR_AUTO);
  options.set_radius(0.5);
  EXPECT_TRUE(IsRefused(options, "radius", {"is 0.5", "unset where the estimator is auto", "max_radius"}));
}

TEST(WriteScaleTest, AcceptedTellsAllThatIsInForce) {
  v1::EstimatorOptions asked = Asking(v1::ESTIMATOR_AUTO, 32);
  asked.mutable_automatic_scale()->set_max_radius(0.5);
  asked.mutable_automatic_scale()->set_per_cloud(true);
  v1::Accepted accepted;
  FillAccepted(*ResolveScale(asked, 300), LimitsOf(300), "id-1", &accepted);
  EXPECT_EQ(accepted.options().estimator(), v1::ESTIMATOR_AUTO);
  ASSERT_TRUE(accepted.options().has_automatic_scale());
  const v1::AutomaticScale& scale = accepted.options().automatic_scale();
  EXPECT_EQ(scale.least_neighbor_count(), 32u);
  EXPECT_EQ(scale.most_neighbor_count(), 300u);
  EXPECT_EQ(scale.max_radius(), 0.5);
  EXPECT_TRUE(scale.per_cloud());
}

TEST(WriteScaleTest, AcceptedOfAFixedCountHasNoScale) {
  v1::EstimatorOptions asked;
  asked.set_estimator(v1::ESTIMATOR_AUTO);
  asked.set_neighbor_count(64);
  v1::Accepted accepted;
  FillAccepted(*ResolveScale(asked), LimitsOf(10'000), "id-1", &accepted);
  EXPECT_EQ(accepted.options().estimator(), v1::ESTIMATOR_AUTO);
  EXPECT_EQ(accepted.options().neighbor_count(), 64u);
}

TEST(WriteReportTest, TellsEveryOutcome) {
  ScaleReport report;
  report.outcomes = {{"avg-hexagram", 0, 64, 0.3, 0.2, 0.1, 0.75}, {"jet", 2, 128, 0.6, 0.5, 0.4, 0.25}};
  report.sampled_points = 512;
  report.sigma = 0.01;
  report.normal_sigma = 0.02;
  report.fitted_normals = {NormalMethod::kJet2, 24};
  report.normals_made_anew = {NormalMethod::kJet4, 96};
  v1::ScaleReport proto;
  WriteReport(report, proto);
  ASSERT_EQ(proto.outcomes_size(), 2);
  EXPECT_EQ(proto.outcomes(0).estimator(), v1::ESTIMATOR_AVG_HEXAGRAM);
  EXPECT_EQ(proto.outcomes(1).estimator(), v1::ESTIMATOR_JET_FITTING);
  EXPECT_EQ(proto.outcomes(0).degree(), 0u);
  EXPECT_EQ(proto.outcomes(1).degree(), 2u);
  EXPECT_EQ(proto.outcomes(1).neighbor_count(), 128u);
  EXPECT_EQ(proto.outcomes(1).error(), 0.6);
  EXPECT_EQ(proto.outcomes(1).noise(), 0.5);
  EXPECT_EQ(proto.outcomes(1).bias(), 0.4);
  EXPECT_EQ(proto.outcomes(1).share(), 0.25);
  EXPECT_EQ(proto.sampled_point_count(), 512u);
  EXPECT_EQ(proto.position_noise(), 0.01);
  EXPECT_EQ(proto.normal_noise(), 0.02);
  EXPECT_EQ(proto.fitted_normals().method(), v1::NORMAL_METHOD_JET_2);
  EXPECT_EQ(proto.fitted_normals().neighbor_count(), 24u);
  EXPECT_EQ(proto.normals_made_anew().method(), v1::NORMAL_METHOD_JET_4);
  EXPECT_EQ(proto.normals_made_anew().neighbor_count(), 96u);
}

TEST(WriteReportTest, NormalsThatAreThoseOfNoFitAreUnset) {
  v1::ScaleReport proto;
  WriteReport(ScaleReport(), proto);
  EXPECT_FALSE(proto.has_fitted_normals());
  EXPECT_FALSE(proto.has_normals_made_anew());
}

}  // namespace
}  // namespace curvd
