#include "core/normals/orientation/link_forest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <vector>

#include "core/estimators/triangles/random_stream.h"

namespace curvd {
namespace {

bool SameLink(const NormalLink& x, const NormalLink& y) { return x.a == y.a && x.b == y.b && x.cost == y.cost; }

// Kruskal's forest of all links.
std::vector<NormalLink> ForestOf(std::vector<NormalLink> links, uint32_t places) {
  std::sort(links.begin(), links.end(), ComesBefore);
  std::vector<uint32_t> set(places);
  std::iota(set.begin(), set.end(), 0u);
  std::vector<NormalLink> forest;
  for (const NormalLink& link : links) {
    const uint32_t a = set[link.a], b = set[link.b];
    if (a == b) continue;
    forest.push_back(link);
    std::replace(set.begin(), set.end(), b, a);
  }
  return forest;
}

std::vector<NormalLink> RandomLinks(uint64_t seed, uint32_t first, uint32_t last, uint32_t places, size_t count) {
  std::vector<NormalLink> links;
  RandomStream random(seed, first);
  while (links.size() < count) {
    const uint32_t a = first + Draw21(random.Next(), last - first), b = Draw21(random.Next(), places);
    // Few costs: ties are broken by places.
    const auto cost = static_cast<float>(Draw21(random.Next(), 8)) / 8.0f;
    if (a != b) links.push_back({cost, a, b, 0});
  }
  std::sort(links.begin(), links.end(),
            [](const NormalLink& x, const NormalLink& y) { return x.a != y.a ? x.a < y.a : x.b < y.b; });
  return links;
}

TEST(LinkForestTest, KeepsKruskalsForestInOrder) {
  ForestScratch scratch;
  for (const size_t count : {0u, 1u, 50u, 400u, 5000u}) {
    std::vector<NormalLink> links = RandomLinks(count, 0, 200, 200, count);
    const std::vector<NormalLink> expected = ForestOf(links, 200);
    links.resize(KeepForest(links.data(), links.size(), 0, 200, scratch));
    ASSERT_EQ(links.size(), expected.size());
    EXPECT_TRUE(std::equal(links.begin(), links.end(), expected.begin(), SameLink));
  }
}

TEST(LinkForestTest, CostsOfAnySizeAreInOrder) {
  constexpr float kCosts[] = {0.0f, 1e-45f, 1e-30f, 0.1f, 0.1000001f, 1.0f, 1.9999999f, 2.0f, 3e38f};
  ForestScratch scratch;
  RandomStream random(1, 2);
  // A star, of which each link is kept.
  std::vector<NormalLink> links;
  for (uint32_t i = 1; i < 500; ++i) links.push_back({kCosts[Draw21(random.Next(), 9)], 0, i, 0});
  std::vector<NormalLink> expected = links;
  std::sort(expected.begin(), expected.end(), ComesBefore);
  for (const uint32_t last : {500u, 1u}) {  // all inside the part; all but one outside
    std::vector<NormalLink> kept = links;
    ASSERT_EQ(KeepForest(kept.data(), kept.size(), 0, last, scratch), links.size());
    EXPECT_TRUE(std::equal(kept.begin(), kept.end(), expected.begin(), SameLink));
  }
}

TEST(LinkForestTest, PlacesHaveNumbersOfTheirOwn) {
  PlaceNumbers numbers;
  for (const size_t others : {0u, 3u, 1000u}) {
    numbers.Reset(100, 200, others);
    EXPECT_EQ(numbers.Of(100), 0u);
    EXPECT_EQ(numbers.Of(199), 99u);
    for (uint32_t i = 0; i < others; ++i) EXPECT_EQ(numbers.Of(200 + 65'536 * i), 100 + i);
    for (uint32_t i = 0; i < others; ++i) EXPECT_EQ(numbers.Of(200 + 65'536 * i), 100 + i);
    EXPECT_EQ(numbers.size(), 100 + others);
  }
}

TEST(LinkForestTest, LosesNothingOfTheForestOfAllParts) {
  ForestScratch scratch;
  for (uint64_t seed = 0; seed < 20; ++seed) {
    std::vector<NormalLink> all, kept;
    for (uint32_t part = 0; part < 5; ++part) {
      std::vector<NormalLink> links = RandomLinks(seed, 100 * part, 100 * part + 100, 500, 600);
      all.insert(all.end(), links.begin(), links.end());
      links.resize(KeepForest(links.data(), links.size(), 100 * part, 100 * part + 100, scratch));
      EXPECT_LT(links.size(), 500u);
      kept.insert(kept.end(), links.begin(), links.end());
    }
    const std::vector<NormalLink> expected = ForestOf(all, 500), found = ForestOf(kept, 500);
    ASSERT_EQ(found.size(), expected.size());
    EXPECT_TRUE(std::equal(found.begin(), found.end(), expected.begin(), SameLink));
  }
}

}  // namespace
}  // namespace curvd
