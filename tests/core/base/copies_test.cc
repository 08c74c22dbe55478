#include "core/base/copies.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace curvd::testing {
namespace {

using Place = std::array<double, 2>;

// Over a disk of radius 1.
std::vector<Place> RandomPlaces(size_t count, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> coordinate(-1.0, 1.0);
  std::vector<Place> places;
  while (places.size() < count) {
    const Place place = {coordinate(random), coordinate(random)};
    if (std::hypot(place[0], place[1]) < 1.0) places.push_back(place);
  }
  return places;
}

bool HaveCopies(const std::vector<Place>& places) {
  NearCopies copies(1.0f, places.size());
  for (size_t i = 0; i < places.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      const double distance = std::hypot(places[i][0] - places[j][0], places[i][1] - places[j][1]);
      copies.AddPair(static_cast<float>(distance * distance));
    }
  }
  return copies.Exist();
}

// A tenth of random places comes twice, as far from each other as this.
std::vector<Place> WithCopies(double distance, uint64_t seed) {
  std::vector<Place> places = RandomPlaces(256, seed);
  for (size_t i = 0; i < 26; ++i) places.push_back({places[i][0] + distance, places[i][1]});
  return places;
}

TEST(NearCopiesTest, ChanceMakesNone) {
  for (uint64_t seed = 0; seed < 100; ++seed) EXPECT_FALSE(HaveCopies(RandomPlaces(256, seed))) << seed;
}

TEST(NearCopiesTest, FewAreFoundHoweverTheyWereRounded) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    for (const double distance : {0.0, 1e-7, 1e-5, 3e-4}) EXPECT_TRUE(HaveCopies(WithCopies(distance, seed)));
    // Their mean distance is 0.1.
    for (const double distance : {1e-3, 0.01, 0.1}) EXPECT_FALSE(HaveCopies(WithCopies(distance, seed)));
  }
}

TEST(NearCopiesTest, PointsOnTheLinesOfAScanAreNone) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> coordinate(-1.0, 1.0);
  for (const bool is_even : {true, false}) {
    for (const size_t on_line : {20, 200, 2'000}) {
      std::vector<Place> places;
      for (const double y : {-0.5, 0.5}) {
        for (size_t i = 0; i < on_line; ++i) {
          places.push_back(
              {is_even ? 2.0 * static_cast<double>(i) / static_cast<double>(on_line) - 1.0 : coordinate(random), y});
        }
      }
      EXPECT_FALSE(HaveCopies(places)) << is_even << " " << on_line;
    }
  }
}

}  // namespace
}  // namespace curvd::testing
