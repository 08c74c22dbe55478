#include "core/job/scale_attempts.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <variant>

#include "core/normals/normal_pilot.h"
#include "tests/core/normals/normal_clouds.h"

namespace curvd::testing {
namespace {

using Step = ScaleAttempts::Step;

constexpr double kSpacing = 0.01;

// What comes of a clean closed surface.
NormalReport Closed(double certificate) {
  NormalReport found;
  found.closed_area_share = 1.0;
  found.certificate = certificate;
  found.max_trusted_certificate = MaxTrustedCertificate(0.0);
  return found;
}

NormalReport Turned(double share, NormalReport found) {
  found.turned_share = share;
  found.turned_share_decides = true;
  return found;
}

class ScaleAttemptsTest : public ::testing::Test {
 protected:
  ScaleAttempts Start(bool two_sheets, double noise_in_spacings, bool has_noisy_part = false) {
    SheetFinding sheets;
    sheets.spacing = kSpacing;
    sheets.noise = noise_in_spacings * kSpacing;
    sheets.two_sheets = two_sheets;
    sheets.neighbor_count = two_sheets ? 12 : 0;
    ChosenFit chosen;
    chosen.fit.neighborhood = NeighborCount{96};
    if (has_noisy_part) chosen.fit.noisy_part = NoisyPart{.neighborhood = NeighborCount{384}};
    return {std::nullopt, sheets, chosen, index_};
  }

  static uint32_t CountOf(const ScaleAttempts& attempts) {
    return std::get<NeighborCount>(attempts.scale().fit.neighborhood).count;
  }
  static NormalReport WithCount(const ScaleAttempts& attempts, NormalReport found) {
    found.neighbor_count = CountOf(attempts);
    return found;
  }

  const SpatialIndex index_ = BuildIndex(Sphere(2'000, 1.0).ToCloud());
};

TEST_F(ScaleAttemptsTest, CleanSheetsKeepTheScaleOfThePilot) {
  ScaleAttempts attempts = Start(false, 0.0);
  EXPECT_EQ(CountOf(attempts), 96);
  EXPECT_EQ(attempts.Next(Closed(0.01)), Step::kDone);
}

TEST_F(ScaleAttemptsTest, SidesOfNoiseAreComparedAndTheScaleOfThePilotMadeAgain) {
  ScaleAttempts attempts = Start(false, 0.5);
  EXPECT_EQ(attempts.Next(WithCount(attempts, Closed(0.01))), Step::kCompare);
  EXPECT_EQ(CountOf(attempts), 48);
  EXPECT_FALSE(attempts.compares_thin());
  EXPECT_EQ(attempts.Next(Turned(0.0, WithCount(attempts, Closed(0.5)))), Step::kFit);
  EXPECT_EQ(CountOf(attempts), 96);
  EXPECT_EQ(attempts.Next(Closed(0.5)), Step::kDone);
}

TEST_F(ScaleAttemptsTest, FewNeighborsStayIfTheirSidesFitMuchBetter) {
  for (const double certificate : {0.29, 0.31}) {
    ScaleAttempts attempts = Start(false, 0.0);
    EXPECT_EQ(attempts.Next(WithCount(attempts, Closed(0.6))), Step::kFit);
    EXPECT_EQ(CountOf(attempts), 17);
    EXPECT_EQ(attempts.Next(Closed(certificate)), certificate < 0.3 ? Step::kDone : Step::kFit);
    EXPECT_EQ(CountOf(attempts), certificate < 0.3 ? 17 : 96);
  }
}

// Half of the neighbors of the quiet part are half of those of the noisy one.
TEST_F(ScaleAttemptsTest, BothPartsOfUnlikeNoiseAreMadeByAnotherScale) {
  ScaleAttempts attempts = Start(false, 0.5, true);
  ASSERT_EQ(attempts.Next(WithCount(attempts, Closed(0.01))), Step::kCompare);
  ASSERT_TRUE(attempts.scale().fit.noisy_part.has_value());
  EXPECT_EQ(attempts.scale().fit.noisy_part->neighborhood.count, 192);
}

TEST_F(ScaleAttemptsTest, EdgesHaveFewerNeighborsThanTheRestOrNoneOfTheirOwn) {
  SheetFinding sheets;
  sheets.spacing = sheets.noise = kSpacing;
  ChosenFit chosen;
  for (const uint32_t count : {96, 40}) {
    chosen.fit.neighborhood = NeighborCount{count};
    chosen.fit.edge_part = EdgePart{.neighborhood = NeighborCount{17}};
    ScaleAttempts attempts(std::nullopt, sheets, chosen, index_);
    ASSERT_EQ(attempts.Next(WithCount(attempts, Closed(0.01))), Step::kCompare);
    EXPECT_EQ(CountOf(attempts), count / 2);
    EXPECT_EQ(attempts.scale().fit.edge_part.has_value(), count / 2 >= 2 * 17);
  }
}

// Scratch is reserved for so many.
TEST_F(ScaleAttemptsTest, NoScaleHasMoreNeighborsThanThePilotTries) {
  SheetFinding sheets;
  sheets.spacing = sheets.noise = kSpacing;
  ChosenFit chosen;
  chosen.fit.neighborhood = NeighborCount{12};
  chosen.fit.noisy_part = NoisyPart{.neighborhood = NeighborCount{NormalPilot::kMostNeighbors}};
  ScaleAttempts attempts(std::nullopt, sheets, chosen, index_);
  ASSERT_EQ(attempts.Next(WithCount(attempts, Closed(0.01))), Step::kCompare);
  EXPECT_EQ(CountOf(attempts), 24);
  EXPECT_EQ(attempts.scale().fit.noisy_part->neighborhood.count, NormalPilot::kMostNeighbors);
}

TEST_F(ScaleAttemptsTest, OneSheetOfTwoStaysIfItIsClosed) {
  ScaleAttempts attempts = Start(true, 0.0);
  EXPECT_EQ(CountOf(attempts), 12);
  EXPECT_EQ(attempts.Next(Closed(0.02)), Step::kDone);
}

TEST_F(ScaleAttemptsTest, RimsAreTriedAndComparedWithTwiceAsManyNeighbors) {
  ScaleAttempts attempts = Start(true, 0.0);
  EXPECT_EQ(attempts.Next(Closed(0.2)), Step::kFit);
  EXPECT_EQ(CountOf(attempts), 24);
  EXPECT_TRUE(attempts.scale().fit.two_sheets);
  EXPECT_EQ(attempts.Next(Closed(0.07)), Step::kFit);  // to be kept, but not beyond doubt
  EXPECT_EQ(CountOf(attempts), 24);
  EXPECT_EQ(attempts.Next(Closed(0.07)), Step::kCompare);
  EXPECT_EQ(CountOf(attempts), 48);
  EXPECT_TRUE(attempts.compares_thin());
  EXPECT_EQ(attempts.Next(Turned(0.0, WithCount(attempts, Closed(0.05)))), Step::kDone);
}

TEST_F(ScaleAttemptsTest, SheetsThatStayOpenGetTheScaleOfThePilot) {
  ScaleAttempts attempts = Start(true, 0.0);
  NormalReport open = Closed(0.02);
  open.closed_area_share = 0.5;
  EXPECT_EQ(attempts.Next(open), Step::kFit);
  EXPECT_EQ(CountOf(attempts), 96);
  EXPECT_FALSE(attempts.scale().fit.two_sheets);
}

TEST_F(ScaleAttemptsTest, ThinScalesAreTriedWhereThatOfThePilotMixesSides) {
  ScaleAttempts attempts = Start(false, 0.0);
  NormalReport mixed = Closed(0.01);
  mixed.mixes_sides = true;
  EXPECT_EQ(attempts.Next(mixed), Step::kFit);
  EXPECT_EQ(CountOf(attempts), 17);
  EXPECT_EQ(attempts.Next(Closed(0.1)), Step::kFit);
  EXPECT_EQ(CountOf(attempts), 24);
  EXPECT_TRUE(attempts.scale().fit.two_sheets);
  EXPECT_EQ(attempts.Next(mixed), Step::kFit);  // the better one is kept
  EXPECT_EQ(CountOf(attempts), 17);
  EXPECT_EQ(attempts.Next(Closed(0.1)), Step::kCompare);
}

}  // namespace
}  // namespace curvd::testing
