#include "core/estimators/options.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace curvd {
namespace {

void ExpectRejected(const EstimatorOptions& options, const char* field, const char* value, const char* limit) {
  const absl::Status status = options.Validate();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  for (const char* part : {field, value, limit}) {
    EXPECT_NE(status.message().find(part), std::string::npos) << status << " lacks " << part;
  }
}

TEST(EstimatorOptionsTest, DefaultsAreValid) { EXPECT_TRUE(EstimatorOptions{}.Validate().ok()); }

TEST(EstimatorOptionsTest, RejectsUnknownEstimatorsAndNamesTheKnownOnes) {
  EstimatorOptions options;
  options.estimator = "hexagon";
  ExpectRejected(options, "estimator", "hexagon", "avg-hexagram, hexagram, uniform");
}

TEST(EstimatorOptionsTest, BoundsOfNeighborCountAreIncluded) {
  EstimatorOptions options;
  for (uint32_t count : {4u, 10'000u}) {
    options.neighborhood = NeighborCount{count};
    EXPECT_TRUE(options.Validate().ok()) << count;
  }
}

TEST(EstimatorOptionsTest, RejectsCountsOutsideTheirBounds) {
  EstimatorOptions options;
  options.neighborhood = NeighborCount{3};
  ExpectRejected(options, "neighbor_count", "3", "from 4 to 10000");
  options.neighborhood = NeighborCount{10'001};
  ExpectRejected(options, "neighbor_count", "10001", "from 4 to 10000");
}

TEST(EstimatorOptionsTest, RejectsRadiiThatAreNoLength) {
  EstimatorOptions options;
  for (double radius : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    options.neighborhood = NeighborRadius{radius};
    ExpectRejected(options, "radius", "radius", "greater than 0");
  }
}

TEST(EstimatorOptionsTest, RejectsCountsOfOneEstimatorOutsideTheirBounds) {
  EstimatorOptions options;
  options.triangle_count = 0;
  ExpectRejected(options, "triangle_count", "0", "from 1 to 10000");
  options = {};
  options.rotation_count = 5;
  ExpectRejected(options, "rotation_count", "5", "from 1 to 4");
  for (const uint32_t degree : {1u, 5u}) {
    options = {};
    options.jet_degree = degree;
    ExpectRejected(options, "jet_degree", degree == 1 ? "is 1" : "is 5", "from 2 to 4");
  }
  for (const uint32_t degree : {0u, 4u}) {
    options = {};
    options.regression_degree = degree;
    ExpectRejected(options, "regression_degree", degree == 0 ? "is 0" : "is 4", "from 1 to 3");
  }
}

TEST(EstimatorOptionsTest, RejectsWeightsOutsideTheUnitInterval) {
  EstimatorOptions options;
  for (double weight : {-0.1, 1.1, std::nan("")}) {
    options.average_normal_weight = weight;
    ExpectRejected(options, "average_normal_weight", "average", "from 0 to 1");
  }
}

}  // namespace
}  // namespace curvd
