#include "core/normals/orientation/link_probe.h"

#include <gtest/gtest.h>

#include <atomic>

#include "core/normals/orientation/normal_links.h"
#include "tests/core/normals/normal_clouds.h"

namespace curvd::testing {
namespace {

size_t LinksOf(const TestPoints& points) {
  const SpatialIndex index = BuildIndex(points.ToCloud());
  LinkProbe probe(index, 1);
  const std::atomic<bool> stopped = false;
  while (probe.AddBlocks()) {
    for (size_t block = 0; block < probe.block_count(); ++block) EXPECT_TRUE(probe.RunBlock(block, 0, stopped).ok());
  }
  return probe.LinksPerPoint();
}

NormalResult Orient(TestPoints points) {
  FlipAtRandom(0.5, 9, points);
  NormalOptions options;
  options.source = NormalSource::kOrient;
  return MustMakeNormals(points.ToCloud(), options);
}

TEST(LinkProbeTest, EvenAndRandomPointsNeedFewLinks) {
  EXPECT_EQ(LinksOf(Sphere(5'000, 1.0)), kLinksPerPoint);
  EXPECT_EQ(LinksOf(Torus(5'000, 1)), kLinksPerPoint);
  EXPECT_EQ(LinksOf(Waves(5'000, 0.0, 2)), kLinksPerPoint);
  EXPECT_EQ(LinksOf(ScannedSaddle(10'000, 2.0, 0.1, 3)), kLinksPerPoint);
}

// Whatever the count, neighbors along a wire lie on a line.
TEST(LinkProbeTest, WiresNeedNoMore) {
  EXPECT_EQ(LinksOf(Pipe(5'000, 1)), kLinksPerPoint);
  TestPoints line;
  for (int i = 0; i < 2000; ++i) line.Add(0.001 * i, 0, 0, 0, 0, 1);
  EXPECT_EQ(LinksOf(line), kLinksPerPoint);
}

TEST(LinkProbeTest, TinyCloudsHaveNone) {
  EXPECT_EQ(LinksOf(Sphere(5, 1.0)), kLinksPerPoint);
  EXPECT_EQ(LinksOf(Sphere(13, 1.0)), kLinksPerPoint);
}

// With 12 links each line is a piece, whose side nothing tells.
TEST(LinkProbeTest, ScanLinesAreOnePiece) {
  for (const double gap : {6.0, 12.0, 40.0}) {
    const TestPoints saddle = ScannedSaddle(20'000, gap, 0.1, 4);
    EXPECT_GT(LinksOf(saddle), kLinksPerPoint) << gap;
    const NormalResult result = Orient(saddle);
    EXPECT_EQ(result.report.piece_count, 1u) << gap;
    EXPECT_EQ(FlippedShare(result.normals, saddle), 0.0) << gap;
  }
}

// Lines that lie in pairs: few neighbors reach the other of a pair, but no more.
TEST(LinkProbeTest, PairsOfLinesAreOnePiece) {
  TestPoints pairs;
  for (int line = 0; line < 40; ++line) {
    const double y = 0.06 * (line / 2) + 0.02 * (line % 2);
    for (int i = 0; i < 400; ++i) pairs.Add(0.005 * i, y, 0.0, 0, 0, 1);
  }
  EXPECT_EQ(Orient(pairs).report.piece_count, 1u);
}

}  // namespace
}  // namespace curvd::testing
