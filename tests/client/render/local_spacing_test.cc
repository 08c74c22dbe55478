#include "client/render/local_spacing.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "client/surfaces/random.h"

namespace curv {
namespace {

double BruteForce(const std::vector<Vec3>& positions, size_t i, size_t rank) {
  std::vector<double> distances;
  for (size_t j = 0; j < positions.size(); ++j) {
    if (j != i) distances.push_back(Norm(positions[i] - positions[j]));
  }
  std::sort(distances.begin(), distances.end());
  return distances.empty() ? 0.0 : distances[std::min(rank, distances.size()) - 1];
}

TEST(LocalSpacingTest, MatchesBruteForce) {
  const CounterRandom random(0, 0);
  std::vector<Vec3> positions;
  for (uint64_t i = 0; i < 500; ++i) {
    positions.push_back({random.Uniform(3 * i), random.Uniform(3 * i + 1), 0.01 * random.Uniform(3 * i + 2)});
  }
  for (const int rank : {1, 6, 32}) {
    const std::vector<double> spacing = LocalSpacing(positions, rank);
    for (size_t i = 0; i < positions.size(); ++i) {
      EXPECT_EQ(spacing[i], BruteForce(positions, i, static_cast<size_t>(rank)));
    }
  }
}

TEST(LocalSpacingTest, ManyEqualPointsAreFast) {
  const std::vector<double> spacing = LocalSpacing(std::vector<Vec3>(50'000, {1, 2, 3}), 6);
  EXPECT_EQ(*std::max_element(spacing.begin(), spacing.end()), 0.0);
}

TEST(LocalSpacingTest, FewPoints) {
  EXPECT_TRUE(LocalSpacing({}, 6).empty());
  EXPECT_EQ(LocalSpacing({{1, 2, 3}}, 6), std::vector<double>{0.0});
  EXPECT_EQ(LocalSpacing({{0, 0, 0}, {0, 0, 2}}, 6), (std::vector<double>{2.0, 2.0}));
}

}  // namespace
}  // namespace curv
