#include "server/call/scale/choice_quantities.h"

#include <gtest/gtest.h>

#include <initializer_list>
#include <limits>

#include "server/call/header_options.h"
#include "server/rpc/error_reasons.h"
#include "tests/server/status_matchers.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;

constexpr CallLimits kCallLimits = {1000, 4096, 10'000, 1 << 30, 10};

v1::CloudHeader ChoiceHeader(v1::Estimator estimator, std::initializer_list<v1::Quantity> quantities) {
  v1::CloudHeader header;
  header.mutable_options()->set_estimator(estimator);
  for (const v1::Quantity quantity : quantities) header.add_quantities(quantity);
  return header;
}

::testing::AssertionResult IsRefusedWith(const v1::CloudHeader& header, std::initializer_list<std::string> words) {
  return IsError(ResolveHeader(header, kCallLimits).status(), absl::StatusCode::kInvalidArgument, kReasonInvalidOption,
                 words);
}

TEST(ChoiceQuantitiesTest, AreWhatMakesAnEstimateReturnChoices) {
  const auto returns_choice = [](const v1::CloudHeader& header) {
    const auto options = ResolveHeader(header, kCallLimits);
    EXPECT_TRUE(options.ok()) << options.status();
    return options->estimator.returns_choice;
  };
  EXPECT_FALSE(returns_choice(ChoiceHeader(v1::ESTIMATOR_AUTO, {})));
  EXPECT_FALSE(returns_choice(ChoiceHeader(v1::ESTIMATOR_AUTO, {v1::QUANTITY_MEAN_CURVATURE})));
  for (const v1::Quantity quantity :
       {v1::QUANTITY_STANDARD_ERRORS, v1::QUANTITY_CHOSEN_NEIGHBOR_COUNT, v1::QUANTITY_ESTIMATOR_WEIGHTS}) {
    EXPECT_TRUE(returns_choice(ChoiceHeader(v1::ESTIMATOR_AUTO, {quantity})));
  }
  EXPECT_TRUE(returns_choice(ChoiceHeader(v1::ESTIMATOR_AVG_HEXAGRAM, {v1::QUANTITY_STANDARD_ERRORS})));
}

TEST(ChoiceQuantitiesTest, StandardErrorsAreOfEstimatesThatASampleCanJudge) {
  v1::CloudHeader header = ChoiceHeader(v1::ESTIMATOR_DELAUNAY, {v1::QUANTITY_STANDARD_ERRORS});
  EXPECT_TRUE(
      IsRefusedWith(header, {"header.options.estimator is delaunay", "auto, avg-hexagram", "header.quantities"}));
  header.mutable_options()->set_estimator(v1::ESTIMATOR_JET_FITTING);
  EXPECT_TRUE(IsRefusedWith(header, {"header.options.jet_degree is 2", "4", "header.quantities"}));
  header.mutable_options()->set_jet_degree(4);
  EXPECT_TRUE(ResolveHeader(header, kCallLimits).ok());
  for (const uint32_t count : {15u, 2049u}) {
    header.mutable_options()->set_neighbor_count(count);
    EXPECT_TRUE(IsRefusedWith(header, {"header.options.neighbor_count", "from 16 to 2048", "header.quantities"}));
  }
  header.mutable_options()->set_radius(1.0);
  EXPECT_TRUE(IsRefusedWith(header, {"header.options.radius is 1", "unset", "header.quantities"}));
}

TEST(ChoiceQuantitiesTest, WhatIsChosenNeedsAChoice) {
  for (const v1::Quantity quantity : {v1::QUANTITY_CHOSEN_NEIGHBOR_COUNT, v1::QUANTITY_ESTIMATOR_WEIGHTS}) {
    v1::CloudHeader header = ChoiceHeader(v1::ESTIMATOR_AVG_HEXAGRAM, {quantity});
    EXPECT_TRUE(IsRefusedWith(header, {"header.quantities", "auto"}));
    header.mutable_options()->mutable_automatic_scale();
    EXPECT_TRUE(ResolveHeader(header, kCallLimits).ok());
  }
}

TEST(ChoiceQuantitiesTest, NormalCurvatureTakesOneDirectionOrThoseOfThePoints) {
  v1::CloudHeader header = ChoiceHeader(v1::ESTIMATOR_AVG_HEXAGRAM, {v1::QUANTITY_NORMAL_CURVATURE});
  EXPECT_TRUE(ResolveHeader(header, kCallLimits)->has_directions());
  header.mutable_curvature_direction()->set_z(-2.0);
  const auto one = ResolveHeader(header, kCallLimits);
  ASSERT_TRUE(one.ok()) << one.status();
  EXPECT_FALSE(one->has_directions());
  EXPECT_EQ(one->curvature_direction, (Direction{0.0f, 0.0f, -1.0f}));
  header.mutable_curvature_direction()->set_z(0.0);
  EXPECT_TRUE(IsRefusedWith(header, {"header.curvature_direction is (0, 0, 0)", "not of length 0"}));
  header.mutable_curvature_direction()->set_x(std::numeric_limits<double>::infinity());
  EXPECT_TRUE(IsRefusedWith(header, {"header.curvature_direction", "inf", "finite"}));
  header.clear_quantities();
  EXPECT_TRUE(IsRefusedWith(header, {"header.curvature_direction", "unset", "header.quantities"}));
}

}  // namespace
}  // namespace curvd
