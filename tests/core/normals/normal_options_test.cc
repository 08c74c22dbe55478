#include "core/normals/normal_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace curvd {
namespace {

using ::testing::HasSubstr;

NormalOptions Estimated() {
  NormalOptions options;
  options.source = NormalSource::kEstimate;
  return options;
}

TEST(NormalOptionsTest, DefaultsAreValidForEachSource) {
  for (const NormalSource source : {NormalSource::kGiven, NormalSource::kOrient, NormalSource::kEstimate}) {
    NormalOptions options;
    options.source = source;
    EXPECT_TRUE(options.Validate(0).ok());
    EXPECT_TRUE(options.Validate(1000).ok());
  }
}

TEST(NormalOptionsTest, CountsMustBeEnoughForTheMethod) {
  NormalOptions options = Estimated();
  for (const auto& [method, least] : {std::pair(NormalMethod::kPca, 4u), std::pair(NormalMethod::kJet1, 4u),
                                      std::pair(NormalMethod::kJet2, 6u), std::pair(NormalMethod::kJet4, 15u)}) {
    options.method = method;
    options.neighborhood = NeighborCount{least};
    EXPECT_TRUE(options.Validate(100).ok());
    options.neighborhood = NeighborCount{least - 1};
    const absl::Status status = options.Validate(100);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(std::string(status.message()), HasSubstr("from " + std::to_string(least) + " to 10000"));
  }
  options.neighborhood = NeighborCount{10'001};
  EXPECT_FALSE(options.Validate(100).ok());
}

TEST(NormalOptionsTest, LengthsMustBeFinite) {
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double bad : {0.0, -1.0, infinity, std::nan("")}) {
    NormalOptions options = Estimated();
    options.neighborhood = NeighborRadius{bad};
    EXPECT_FALSE(options.Validate(10).ok()) << bad;
  }
  for (const double bad : {infinity, std::nan("")}) {
    NormalOptions options = Estimated();
    options.sides = SidesTowardViewpoint{{0, bad, 0}};
    EXPECT_FALSE(options.Validate(10).ok()) << bad;
    options.sides = SidesAlongDirection{{0, bad, 0}};
    EXPECT_FALSE(options.Validate(10).ok()) << bad;
  }
}

TEST(NormalOptionsTest, DirectionsMustHaveOne) {
  NormalOptions options = Estimated();
  options.sides = SidesAlongDirection{{0, 0, 0}};
  EXPECT_THAT(std::string(options.Validate(10).message()), HasSubstr("not zero"));
  options.sides = SidesAlongDirection{{0, 0, 1e-300}};
  EXPECT_TRUE(options.Validate(10).ok());
}

TEST(NormalOptionsTest, EachPointNeedsAViewpoint) {
  const std::vector<std::array<double, 3>> viewpoints(5);
  NormalOptions options = Estimated();
  options.sides = SidesTowardViewpoints{viewpoints};
  EXPECT_TRUE(options.Validate(5).ok());
  EXPECT_THAT(std::string(options.Validate(6).message()), HasSubstr("is a list of 5; it must be a list of 6"));
}

TEST(NormalOptionsTest, GivenNormalsLeaveTheRestUnread) {
  NormalOptions options;
  options.neighborhood = NeighborCount{0};
  options.sides = SidesAlongDirection{{0, 0, 0}};
  EXPECT_TRUE(options.Validate(10).ok());
}

}  // namespace
}  // namespace curvd
