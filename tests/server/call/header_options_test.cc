#include "server/call/header_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "proto/result_columns.h"
#include "server/rpc/error_reasons.h"
#include "tests/server/status_matchers.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;

constexpr CallLimits kLimits = {1000, 4096, 100, 1 << 30, 10};
constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;

absl::Status Refusal(const v1::CloudHeader& header) { return ResolveHeader(header, kLimits).status(); }

TEST(ResolveHeaderTest, GivesAnEmptyHeaderTheDocumentedDefaults) {
  const auto options = ResolveHeader({}, kLimits);
  ASSERT_TRUE(options.ok()) << options.status();
  EXPECT_EQ(options->point_count, 0u);
  EXPECT_EQ(options->scalar_type, ScalarType::kFloat32);
  EXPECT_EQ(options->estimator.estimator, "avg-hexagram");
  EXPECT_EQ(std::get<NeighborCount>(options->estimator.neighborhood).count, 50u);
  EXPECT_EQ(options->estimator.triangle_count, 100u);
  EXPECT_EQ(options->estimator.seed, 0u);
  EXPECT_EQ(options->estimator.average_normal_weight, 0.5);
  EXPECT_EQ(options->estimator.max_neighbor_count, 100u);
  EXPECT_EQ(options->invalid_point_policy, InvalidPointPolicy::kReject);
  EXPECT_EQ(options->estimator.opposed_normals, OpposedNormalsPolicy::kMark);
  EXPECT_FALSE(options->priority.has_value());
  EXPECT_EQ(options->normals.source, NormalSource::kGiven);
  EXPECT_FALSE(options->normals.returns_normals);
  for (const v1::Quantity quantity : curvature::wire::Quantities()) {
    const auto& columns = curvature::wire::ResultColumns();
    const auto column =
        std::find_if(columns.begin(), columns.end(), [&](const auto& each) { return each.quantity == quantity; });
    EXPECT_EQ(options->quantities.Has(quantity), !column->on_request) << column->name;
  }
}

TEST(ResolveHeaderTest, NormalsThatTheServerMakesComeBackUnlessOtherQuantitiesAreAskedFor) {
  v1::CloudHeader header;
  header.mutable_normals()->set_source(v1::NORMAL_SOURCE_ESTIMATE);
  const auto all = ResolveHeader(header, kLimits);
  ASSERT_TRUE(all.ok()) << all.status();
  EXPECT_EQ(all->normals.source, NormalSource::kEstimate);
  EXPECT_TRUE(all->quantities.Has(v1::QUANTITY_NORMALS) && all->normals.returns_normals);
  EXPECT_TRUE(all->quantities.HasCurvature());
  EXPECT_FALSE(all->quantities.Has(v1::QUANTITY_NORMAL_QUALITY));
  header.add_quantities(v1::QUANTITY_MEAN_CURVATURE);
  const auto mean = ResolveHeader(header, kLimits);
  EXPECT_FALSE(mean->quantities.HasNormals() || mean->normals.returns_normals);
}

TEST(ResolveHeaderTest, ACallMayAskForNormalsAlone) {
  v1::CloudHeader header;
  header.add_quantities(v1::QUANTITY_NORMALS);
  header.add_quantities(v1::QUANTITY_NORMAL_QUALITY);
  const auto options = ResolveHeader(header, kLimits);
  ASSERT_TRUE(options.ok()) << options.status();
  EXPECT_FALSE(options->quantities.HasCurvature());
  EXPECT_TRUE(options->normals.returns_normals);
}

TEST(ResolveHeaderTest, KnowsWhatComesWithEachPoint) {
  CallOptions options;
  EXPECT_EQ(options.point_bytes(), 24u);
  options.normals.source = NormalSource::kEstimate;
  EXPECT_EQ(options.point_bytes(), 12u);
  options.normals.sides = SidesTowardViewpoints{};
  options.scalar_type = ScalarType::kFloat64;
  EXPECT_EQ(options.point_bytes(), 48u);
}

TEST(ResolveHeaderTest, RefusesAnUnknownPriority) {
  v1::CloudHeader header;
  header.set_priority(static_cast<v1::Priority>(3));
  EXPECT_TRUE(IsError(Refusal(header), kInvalid, kReasonInvalidOption, {"header.priority", "3", "batch"}));
}

TEST(ResolveHeaderTest, TakesAPolicyForOpposedNormals) {
  v1::CloudHeader header;
  header.set_opposed_normals_policy(v1::OPPOSED_NORMALS_POLICY_REJECT);
  EXPECT_EQ(ResolveHeader(header, kLimits)->estimator.opposed_normals, OpposedNormalsPolicy::kReject);
  header.set_opposed_normals_policy(v1::OPPOSED_NORMALS_POLICY_MARK);
  EXPECT_EQ(ResolveHeader(header, kLimits)->estimator.opposed_normals, OpposedNormalsPolicy::kMark);
  header.set_opposed_normals_policy(static_cast<v1::OpposedNormalsPolicy>(3));
  EXPECT_TRUE(
      IsError(Refusal(header), kInvalid, kReasonInvalidOption, {"header.opposed_normals_policy", "3", "reject"}));
}

TEST(ResolveHeaderTest, RejectsOpposedNormalsOnlyWhereTheyAreLookedFor) {
  v1::CloudHeader header;
  header.set_opposed_normals_policy(v1::OPPOSED_NORMALS_POLICY_REJECT);
  header.add_quantities(v1::QUANTITY_NORMALS);
  EXPECT_TRUE(IsError(Refusal(header), kInvalid, kReasonInvalidOption,
                      {"header.opposed_normals_policy", "2", "a quantity of curvature"}));
  header.add_quantities(v1::QUANTITY_RADIUS);
  EXPECT_EQ(ResolveHeader(header, kLimits)->estimator.opposed_normals, OpposedNormalsPolicy::kReject);
}

TEST(ResolveHeaderTest, TakesEveryFieldAsGiven) {
  v1::CloudHeader header;
  header.set_point_count(1000);
  header.set_scalar_type(v1::SCALAR_TYPE_FLOAT64);
  header.mutable_options()->set_estimator(v1::ESTIMATOR_UNIFORM);
  header.mutable_options()->set_radius(0.25);
  header.mutable_options()->set_triangle_count(7);
  header.mutable_options()->set_seed(9);
  header.mutable_options()->set_average_normal_weight(0.0);
  header.add_quantities(v1::QUANTITY_RADIUS);
  header.set_invalid_point_policy(v1::INVALID_POINT_POLICY_SKIP);
  header.set_request_tag("scan 7");
  header.set_priority(v1::PRIORITY_BATCH);
  header.set_marks_last_chunk(true);
  const auto options = ResolveHeader(header, kLimits);
  ASSERT_TRUE(options.ok()) << options.status();
  EXPECT_TRUE(options->marks_last_chunk);
  EXPECT_EQ(options->scalar_type, ScalarType::kFloat64);
  EXPECT_EQ(options->estimator.estimator, "uniform");
  EXPECT_EQ(std::get<NeighborRadius>(options->estimator.neighborhood).radius, 0.25);
  EXPECT_EQ(options->estimator.triangle_count, 7u);
  EXPECT_EQ(options->estimator.seed, 9u);
  EXPECT_EQ(options->estimator.average_normal_weight, 0.0);
  EXPECT_TRUE(options->quantities.Has(v1::QUANTITY_RADIUS));
  EXPECT_FALSE(options->quantities.Has(v1::QUANTITY_MEAN_CURVATURE));
  EXPECT_EQ(options->invalid_point_policy, InvalidPointPolicy::kSkip);
  EXPECT_EQ(options->request_tag, "scan 7");
  EXPECT_EQ(options->priority, std::optional<JobPriority>(JobPriority::kBatch));
}

TEST(ResolveHeaderTest, RefusesTooManyPoints) {
  v1::CloudHeader header;
  header.set_point_count(1001);
  EXPECT_TRUE(IsError(Refusal(header), absl::StatusCode::kResourceExhausted, kReasonTooManyPoints,
                      {"header.point_count", "1001", "1000", "max_points"}));
}

TEST(ResolveHeaderTest, RefusesNeighborCountsOutsideTheirRange) {
  v1::CloudHeader header;
  header.mutable_options()->set_neighbor_count(3);
  EXPECT_TRUE(
      IsError(Refusal(header), kInvalid, kReasonInvalidOption, {"header.options.neighbor_count", "3", "at least 4"}));
  header.mutable_options()->set_neighbor_count(101);
  EXPECT_TRUE(IsError(Refusal(header), absl::StatusCode::kResourceExhausted, kReasonNeighborhoodTooLarge,
                      {"header.options.neighbor_count", "101", "at most 100", "max_neighbor_count"}));
  header.mutable_options()->set_neighbor_count(4);
  EXPECT_TRUE(Refusal(header).ok());
}

TEST(ResolveHeaderTest, RefusesRadiiThatAreNoLength) {
  for (const double radius : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    v1::CloudHeader header;
    header.mutable_options()->set_radius(radius);
    EXPECT_TRUE(IsError(Refusal(header), kInvalid, kReasonInvalidOption, {"header.options.radius", "above 0"}))
        << radius;
  }
}

TEST(ResolveHeaderTest, RefusesCountsThatNoChoiceCanJudge) {
  v1::CloudHeader header;
  header.mutable_options()->set_estimator(v1::ESTIMATOR_AUTO);
  header.mutable_options()->set_neighbor_count(10);
  const absl::Status status = Refusal(header);
  EXPECT_TRUE(IsError(status, kInvalid, kReasonInvalidOption, {"header.options.neighbor_count is 10", "from 16 to"}));
  EXPECT_EQ(MetadataOf(status, "field"), "header.options.neighbor_count");
  EXPECT_EQ(MetadataOf(status, "value"), "10");
}

TEST(ResolveHeaderTest, RefusesALatticeThatIsNone) {
  v1::CloudHeader header;
  header.mutable_part()->mutable_lattice()->set_spacing(0.3);
  absl::Status status = Refusal(header);
  EXPECT_TRUE(IsError(status, kInvalid, kReasonInvalidOption, {"header.part.lattice.spacing is 0.3", "power of two"}));
  EXPECT_EQ(MetadataOf(status, "field"), "header.part.lattice.spacing");
  header.mutable_part()->mutable_lattice()->set_spacing(0.25);
  header.mutable_part()->mutable_lattice()->mutable_origin()->set_y(0.3);
  status = Refusal(header);
  EXPECT_TRUE(IsError(status, kInvalid, kReasonInvalidOption, {"header.part.lattice.origin.y is 0.3", "0.25"}));
  EXPECT_EQ(MetadataOf(status, "value"), "0.3");
}

TEST(ResolveHeaderTest, RefusesTooManyTriangles) {
  v1::CloudHeader header;
  header.mutable_options()->set_triangle_count(10'001);
  EXPECT_TRUE(IsError(Refusal(header), kInvalid, kReasonInvalidOption,
                      {"header.options.triangle_count", "10001", "at most 10000"}));
}

TEST(ResolveHeaderTest, RefusesTooManyRotations) {
  v1::CloudHeader header;
  EXPECT_EQ(ResolveHeader(header, kLimits)->estimator.rotation_count, 2u);
  header.mutable_options()->set_rotation_count(5);
  EXPECT_TRUE(
      IsError(Refusal(header), kInvalid, kReasonInvalidOption, {"header.options.rotation_count", "5", "at most 4"}));
}

TEST(ResolveHeaderTest, RefusesJetsOfOtherDegrees) {
  v1::CloudHeader header;
  EXPECT_EQ(ResolveHeader(header, kLimits)->estimator.jet_degree, 2u);
  header.mutable_options()->set_jet_degree(4);
  EXPECT_EQ(ResolveHeader(header, kLimits)->estimator.jet_degree, 4u);
  for (const uint32_t degree : {1u, 5u}) {
    header.mutable_options()->set_jet_degree(degree);
    EXPECT_TRUE(IsError(Refusal(header), kInvalid, kReasonInvalidOption,
                        {"header.options.jet_degree", std::to_string(degree), "from 2 to 4"}));
  }
}

TEST(ResolveHeaderTest, TakesEvenWeights) {
  v1::CloudHeader header;
  EXPECT_FALSE(ResolveHeader(header, kLimits)->estimator.even_weights);
  header.mutable_options()->set_even_weights(true);
  EXPECT_TRUE(ResolveHeader(header, kLimits)->estimator.even_weights);
}

TEST(ResolveHeaderTest, TakesProjecting) {
  v1::CloudHeader header;
  EXPECT_FALSE(ResolveHeader(header, kLimits)->estimator.project);
  header.mutable_options()->set_project(true);
  EXPECT_TRUE(ResolveHeader(header, kLimits)->estimator.project);
}

TEST(ResolveHeaderTest, RefusesWeightsOutsideTheUnitInterval) {
  for (const double weight : {-0.1, 1.1, std::nan("")}) {
    v1::CloudHeader header;
    header.mutable_options()->set_average_normal_weight(weight);
    EXPECT_TRUE(
        IsError(Refusal(header), kInvalid, kReasonInvalidOption, {"header.options.average_normal_weight", "[0, 1]"}))
        << weight;
  }
}

TEST(ResolveHeaderTest, RefusesEnumValuesThatItDoesNotKnow) {
  v1::CloudHeader header;
  header.mutable_options()->set_estimator(static_cast<v1::Estimator>(99));
  EXPECT_TRUE(IsError(Refusal(header), kInvalid, kReasonInvalidOption, {"header.options.estimator", "99"}));
  header = {};
  header.set_scalar_type(static_cast<v1::ScalarType>(99));
  EXPECT_TRUE(IsError(Refusal(header), kInvalid, kReasonInvalidOption, {"header.scalar_type", "99"}));
  header = {};
  header.set_invalid_point_policy(static_cast<v1::InvalidPointPolicy>(99));
  EXPECT_TRUE(IsError(Refusal(header), kInvalid, kReasonInvalidOption, {"header.invalid_point_policy", "99"}));
  header = {};
  header.add_quantities(static_cast<v1::Quantity>(99));
  EXPECT_TRUE(IsError(Refusal(header), kInvalid, kReasonInvalidOption, {"header.quantities[0]", "99"}));
}

TEST(ResolveHeaderTest, RefusesUnspecifiedAndRepeatedQuantities) {
  v1::CloudHeader header;
  header.add_quantities(v1::QUANTITY_UNSPECIFIED);
  EXPECT_TRUE(IsError(Refusal(header), kInvalid, kReasonInvalidOption, {"header.quantities[0]", "0"}));
  header.clear_quantities();
  header.add_quantities(v1::QUANTITY_RADIUS);
  header.add_quantities(v1::QUANTITY_RADIUS);
  EXPECT_TRUE(IsError(Refusal(header), kInvalid, kReasonInvalidOption, {"header.quantities[1]", "5", "at most once"}));
}

TEST(ResolveHeaderTest, RefusesAnOriginThatIsNotFinite) {
  v1::CloudHeader header;
  header.mutable_origin()->set_y(std::nan(""));
  EXPECT_TRUE(IsError(Refusal(header), kInvalid, kReasonInvalidOption, {"header.origin.y", "nan", "finite"}));
}

TEST(ResolveHeaderTest, RefusesTagsThatALogCannotShow) {
  v1::CloudHeader header;
  header.set_request_tag(std::string(128, 'x'));
  EXPECT_TRUE(Refusal(header).ok());
  header.set_request_tag(std::string(129, 'x'));
  EXPECT_TRUE(IsError(Refusal(header), kInvalid, kReasonInvalidOption, {"header.request_tag", "129", "128"}));
  header.set_request_tag("ab\nc");
  EXPECT_TRUE(IsError(Refusal(header), kInvalid, kReasonInvalidOption, {"header.request_tag[2]", "0x0a", "ASCII"}));
}

TEST(FillAcceptedTest, TellsTheOptionsInForce) {
  v1::CloudHeader header;
  header.mutable_options()->set_radius(2.0);
  header.add_quantities(v1::QUANTITY_GAUSSIAN_CURVATURE);
  const auto options = ResolveHeader(header, kLimits);
  ASSERT_TRUE(options.ok());
  v1::Accepted accepted;
  FillAccepted(*options, kLimits, "id-1", &accepted);
  EXPECT_EQ(accepted.request_id(), "id-1");
  EXPECT_EQ(accepted.options().estimator(), v1::ESTIMATOR_AVG_HEXAGRAM);
  EXPECT_EQ(accepted.options().radius(), 2.0);
  EXPECT_EQ(accepted.options().triangle_count(), 100u);
  EXPECT_EQ(accepted.options().rotation_count(), 2u);
  EXPECT_EQ(accepted.options().jet_degree(), 2u);
  EXPECT_EQ(accepted.options().average_normal_weight(), 0.5);
  ASSERT_EQ(accepted.quantities_size(), 1);
  EXPECT_EQ(accepted.quantities(0), v1::QUANTITY_GAUSSIAN_CURVATURE);
  EXPECT_EQ(accepted.limits().max_points(), 1000u);
  EXPECT_EQ(accepted.limits().max_chunk_bytes(), 4096u);
  EXPECT_EQ(accepted.limits().max_neighbor_count(), 100u);
  EXPECT_EQ(accepted.limits().memory_bytes(), uint64_t{1} << 30);
  EXPECT_EQ(accepted.limits().max_streams(), 10u);
}

TEST(FillEstimatorsTest, NamesEveryEstimatorThatMayBeAskedFor) {
  v1::GetServerInfoResponse info;
  FillEstimators(&info);
  int accepted = 0;
  for (int estimator = v1::ESTIMATOR_UNSPECIFIED + 1; estimator < v1::Estimator_ARRAYSIZE; ++estimator) {
    v1::CloudHeader header;
    header.mutable_options()->set_estimator(static_cast<v1::Estimator>(estimator));
    if (Refusal(header).ok()) ++accepted;
  }
  EXPECT_EQ(info.estimators_size(), accepted);
  EXPECT_THAT(info.estimators(), ::testing::Contains(v1::ESTIMATOR_AUTO));
}

v1::CloudHeader WithCounts(std::initializer_list<uint32_t> counts) {
  v1::CloudHeader header;
  for (const uint32_t count : counts) header.mutable_options()->add_neighbor_counts(count);
  return header;
}

TEST(ResolveHeaderTest, SeveralNeighborCountsAreTakenAndTold) {
  const auto options = ResolveHeader(WithCounts({16, 50, 100}), kLimits);
  ASSERT_TRUE(options.ok()) << options.status();
  EXPECT_TRUE(options->names_counts);
  EXPECT_EQ(std::get<NeighborCount>(options->estimator.neighborhood).count, 100u);
  EXPECT_THAT(options->estimator.smaller_counts.span(), ::testing::ElementsAre(50u, 16u));
  v1::Accepted accepted;
  FillAccepted(*options, kLimits, "", &accepted);
  EXPECT_THAT(accepted.options().neighbor_counts(), ::testing::ElementsAre(16u, 50u, 100u));
  EXPECT_EQ(accepted.options().neighborhood_case(), v1::EstimatorOptions::NEIGHBORHOOD_NOT_SET);
  // One of any estimator.
  v1::CloudHeader one = WithCounts({30});
  one.mutable_options()->set_estimator(v1::ESTIMATOR_JET_FITTING);
  EXPECT_TRUE(Refusal(one).ok());
}

TEST(ResolveHeaderTest, RefusesNeighborCountsThatItCannotServe) {
  const auto refused = [](const v1::CloudHeader& header, const char* field, const char* value, const char* limit) {
    return IsError(Refusal(header), kInvalid, kReasonInvalidOption, {field, value, limit});
  };
  EXPECT_TRUE(refused(WithCounts({3, 16}), "header.options.neighbor_counts[0]", "3", "at least 4"));
  EXPECT_TRUE(
      refused(WithCounts({16, 16}), "header.options.neighbor_counts[1]", "16", "above the count before it, 16"));
  EXPECT_TRUE(IsError(Refusal(WithCounts({16, 101})), absl::StatusCode::kResourceExhausted, kReasonNeighborhoodTooLarge,
                      {"header.options.neighbor_counts[1]", "101", "at most 100", "max_neighbor_count"}));
  EXPECT_TRUE(refused(WithCounts({4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20}),
                      "header.options.neighbor_counts", "a list of 17", "at most 16"));
  v1::CloudHeader header = WithCounts({16, 32});
  header.mutable_options()->set_radius(1.0);
  EXPECT_TRUE(refused(header, "header.options.neighbor_counts", "a list of 2", "unset where neighbor_count, radius"));
  header = WithCounts({16, 32});
  for (const v1::Estimator estimator : {v1::ESTIMATOR_JET_FITTING, v1::ESTIMATOR_AUTO, v1::ESTIMATOR_UNIFORM}) {
    header.mutable_options()->set_estimator(estimator);
    EXPECT_TRUE(refused(header, "header.options.estimator", "", "one of avg-hexagram, normal-regression"));
  }
  header = WithCounts({16, 32});
  header.add_quantities(v1::QUANTITY_STANDARD_ERRORS);
  EXPECT_TRUE(refused(header, "header.options.neighbor_counts", "a list of 2", "a list of one"));
  header = WithCounts({16, 32});
  header.add_quantities(v1::QUANTITY_NORMALS);
  EXPECT_TRUE(refused(header, "header.options.neighbor_counts", "set", "a quantity of curvature"));
}

}  // namespace
}  // namespace curvd
