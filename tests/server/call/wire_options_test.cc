#include "server/call/wire_options.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "core/estimators/option_specs.h"
#include "server/rpc/error_reasons.h"
#include "tests/server/status_matchers.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;

constexpr auto kInvalidArgument = absl::StatusCode::kInvalidArgument;

TEST(WireOptionsTest, EveryOptionIsAFieldOfItsTypeInTheContract) {
  using Field = google::protobuf::FieldDescriptor;
  constexpr Field::CppType kTypes[] = {Field::CPPTYPE_UINT32, Field::CPPTYPE_UINT64, Field::CPPTYPE_DOUBLE,
                                       Field::CPPTYPE_BOOL};
  for (const OptionSpec& spec : OptionSpecs()) {
    const Field* field = v1::EstimatorOptions::descriptor()->FindFieldByName(std::string(spec.name));
    ASSERT_NE(field, nullptr) << spec.name;
    EXPECT_EQ(field->cpp_type(), kTypes[spec.member.index()]) << spec.name;
    EXPECT_FALSE(field->is_repeated()) << spec.name;
  }
}

TEST(WireOptionsTest, WhatIsNotSetKeepsItsDefault) {
  EstimatorOptions options;
  ASSERT_TRUE(ReadOptions({}, options).ok());
  EXPECT_EQ(options.triangle_count, EstimatorOptions{}.triangle_count);
  EXPECT_EQ(options.average_normal_weight, EstimatorOptions{}.average_normal_weight);
  EXPECT_FALSE(options.even_weights);
}

TEST(WireOptionsTest, ZeroIsAValueWhereTheFieldHasPresence) {
  v1::EstimatorOptions proto;
  proto.set_average_normal_weight(0.0);
  EstimatorOptions options;
  ASSERT_TRUE(ReadOptions(proto, options).ok());
  EXPECT_EQ(options.average_normal_weight, 0.0);
}

TEST(WireOptionsTest, WhatIsWrittenIsReadAgain) {
  EstimatorOptions written;
  written.triangle_count = 7;
  written.seed = ~uint64_t{0};
  written.average_normal_weight = 0.25;
  written.rotation_count = 3;
  written.jet_degree = 4;
  written.regression_degree = 2;
  written.even_weights = true;
  written.project = true;
  v1::EstimatorOptions proto;
  WriteOptions(written, proto);
  EstimatorOptions read;
  ASSERT_TRUE(ReadOptions(proto, read).ok());
  EXPECT_EQ(read.triangle_count, 7u);
  EXPECT_EQ(read.seed, ~uint64_t{0});
  EXPECT_EQ(read.average_normal_weight, 0.25);
  EXPECT_EQ(read.rotation_count, 3u);
  EXPECT_EQ(read.jet_degree, 4u);
  EXPECT_EQ(read.regression_degree, 2u);
  EXPECT_TRUE(read.even_weights && read.project);
}

TEST(WireOptionsTest, ANumberBesideTheBoundDoesNotLookLikeIt) {
  EstimatorOptions options;
  v1::EstimatorOptions proto;
  proto.set_average_normal_weight(1.0000001);
  const absl::Status status = ReadOptions(proto, options);
  EXPECT_TRUE(IsError(status, kInvalidArgument, kReasonInvalidOption, {"is 1.0000001; it must be in [0, 1]"}));
  EXPECT_EQ(MetadataOf(status, "value"), "1.0000001");
}

TEST(WireOptionsTest, RefusalsNameFieldValueAndRange) {
  EstimatorOptions options;
  v1::EstimatorOptions proto;
  proto.set_triangle_count(10'001);
  EXPECT_TRUE(IsError(ReadOptions(proto, options), kInvalidArgument, kReasonInvalidOption,
                      {"header.options.triangle_count", "10001", "at most 10000"}));
  proto.Clear();
  proto.set_jet_degree(1);
  EXPECT_TRUE(IsError(ReadOptions(proto, options), kInvalidArgument, kReasonInvalidOption,
                      {"header.options.jet_degree", "1", "from 2 to 4"}));
  proto.Clear();
  proto.set_regression_degree(4);
  EXPECT_TRUE(IsError(ReadOptions(proto, options), kInvalidArgument, kReasonInvalidOption,
                      {"header.options.regression_degree", "4", "at most 3"}));
  for (const double weight : {-0.5, 1.5, std::numeric_limits<double>::infinity(), std::nan("")}) {
    proto.Clear();
    proto.set_average_normal_weight(weight);
    EXPECT_TRUE(IsError(ReadOptions(proto, options), kInvalidArgument, kReasonInvalidOption,
                        {"header.options.average_normal_weight", "in [0, 1]"}))
        << weight;
  }
}

}  // namespace
}  // namespace curvd
