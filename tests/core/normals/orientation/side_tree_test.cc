#include "core/normals/orientation/side_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "tests/core/normals/normal_clouds.h"

namespace curvd::testing {
namespace {

// All links of an index, in any order.
std::vector<NormalLink> LinksOf(const SpatialIndex& index) {
  LinkScratch scratch;
  const NeighborhoodPlan plan = LinkSearch(index);
  std::vector<PackedArea> areas(index.point_count());
  scratch.reaches.Reserve(index.point_count() + SpatialIndex::kGroupPoints);
  for (size_t group = 0; group < index.group_count(); ++group) {
    EXPECT_TRUE(AppendLinks(index, plan, group, scratch, areas.data()).ok());
  }
  return {scratch.links.data(), scratch.links.data() + scratch.link_count};
}

void RunRounds(SideTree& tree) {
  const auto each_chunk = [&tree](void (SideTree::*run)(size_t)) {
    for (size_t chunk = 0; chunk < tree.chunk_count(); ++chunk) (tree.*run)(chunk);
  };
  while (tree.BeginRound()) {
    each_chunk(&SideTree::Propose);
    each_chunk(&SideTree::Follow);
    each_chunk(&SideTree::Flatten);
    each_chunk(&SideTree::EndRound);
  }
  each_chunk(&SideTree::FlattenPlaces);
  tree.JoinClusters();
}

// A place and the side relative to it, for each place, once the certain links are joined in order (Kruskal).
struct Side {
  uint32_t root;
  bool is_opposite;
};
std::vector<Side> SidesByCertainLinks(std::vector<NormalLink> links, size_t places) {
  std::sort(links.begin(), links.end(), ComesBefore);
  std::vector<Side> sides(places);
  std::vector<std::vector<uint32_t>> members(places);
  for (uint32_t i = 0; i < places; ++i) {
    sides[i] = {i, false};
    members[i] = {i};
  }
  for (const NormalLink& link : links) {
    uint32_t a = sides[link.a].root, b = sides[link.b].root;
    if (a == b || link.cost > SideTree::kCertain) continue;
    const bool turns = (sides[link.a].is_opposite != sides[link.b].is_opposite) != (link.opposite != 0);
    if (members[a].size() < members[b].size()) std::swap(a, b);
    for (const uint32_t place : members[b]) {
      sides[place] = {a, sides[place].is_opposite != turns};
      members[a].push_back(place);
    }
    members[b].clear();
  }
  return sides;
}

// With so much noise that links are of both kinds, and that ways around differ in what they say.
Cloud NoisyTorus() {
  TestPoints torus = Torus(15'000, 1);
  AddNoise(0.05, 2, torus);
  FlipAtRandom(0.5, 3, torus);
  return torus.ToCloud();
}

class SideTreeTest : public ::testing::Test {
 protected:
  const SpatialIndex index_ = BuildIndex(NoisyTorus());
};

TEST_F(SideTreeTest, JoinsAlongTheCheapestCertainLinks) {
  SideTree tree(index_);
  ASSERT_TRUE(tree.Start().ok());
  ASSERT_GT(tree.chunk_count(), 3u);
  LinkScratch links;
  ForestScratch forest;
  for (size_t chunk = 0; chunk < tree.chunk_count(); ++chunk) {
    const auto rest = tree.Link(chunk * SideTree::kChunkPoints, links, forest);
    ASSERT_TRUE(rest.ok());
    ASSERT_EQ(*rest, SideTree::kNoRest);
  }
  RunRounds(tree);

  const std::vector<Side> expected = SidesByCertainLinks(LinksOf(index_), index_.point_count());
  size_t joined = 0, opposite = 0;
  for (size_t place = 0; place < expected.size(); ++place) {
    const uint32_t root = expected[place].root;
    ASSERT_EQ(tree.cluster(place), tree.cluster(root));
    const bool is_opposite = tree.is_opposite(place) != tree.is_opposite(root);
    ASSERT_EQ(is_opposite, expected[place].is_opposite) << place;
    joined += root != place ? 1 : 0;
    opposite += is_opposite ? 1 : 0;
  }
  EXPECT_GT(joined, expected.size() / 2);
  EXPECT_LT(joined, expected.size() - 100);  // some links are uncertain
  EXPECT_GT(opposite, joined / 4);
}

TEST_F(SideTreeTest, CountsThePointsOfClusters) {
  SideTree tree(index_);
  ASSERT_TRUE(tree.Start().ok());
  LinkScratch links;
  ForestScratch forest;
  for (size_t chunk = 0; chunk < tree.chunk_count(); ++chunk) {
    ASSERT_TRUE(tree.Link(chunk * SideTree::kChunkPoints, links, forest).ok());
  }
  RunRounds(tree);
  std::vector<uint32_t> counts(tree.clusters().size());
  for (size_t place = 0; place < index_.point_count(); ++place) ++counts[tree.cluster(place)];
  for (size_t i = 0; i < counts.size(); ++i) {
    EXPECT_EQ(tree.clusters()[i].points, counts[i]);
    EXPECT_EQ(tree.cluster(tree.clusters()[i].root), i);
  }
}

TEST_F(SideTreeTest, FewLinksComeFromBothEnds) {
  std::vector<NormalLink> links = LinksOf(index_);
  for (NormalLink& link : links) {
    const uint32_t a = link.a, b = link.b;
    link = {link.cost, std::min(a, b), std::max(a, b), link.opposite};
  }
  const auto is_before = [](const NormalLink& x, const NormalLink& y) { return x.a != y.a ? x.a < y.a : x.b < y.b; };
  std::sort(links.begin(), links.end(), is_before);
  const auto is_same = [](const NormalLink& x, const NormalLink& y) { return x.a == y.a && x.b == y.b; };
  const auto last = std::unique(links.begin(), links.end(), is_same);
  // Only the farthest neighbor of a point, of the 12 that each has, may link back.
  const auto twice = static_cast<size_t>(links.end() - last), once = static_cast<size_t>(last - links.begin());
  EXPECT_LT(twice, index_.point_count());
  EXPECT_GT(once, 6 * index_.point_count());
  EXPECT_LT(once, 9 * index_.point_count());
}

}  // namespace
}  // namespace curvd::testing
