#include "server/result_encoder.h"

#include <gtest/gtest.h>

#include <cstring>
#include <string>

#include "tests/core/numbered_points.h"

namespace curvd {
namespace {

float FloatAt(const std::string& bytes, size_t i) {
  float value = 0.0f;
  std::memcpy(&value, bytes.data() + i * sizeof(float), sizeof(float));
  return value;
}

PageArray<PointCurvature> Points(size_t count) {
  PageArray<PointCurvature> points = *PageArray<PointCurvature>::Create(count);
  for (size_t i = 0; i < count; ++i) points[i] = NumberedPoint(i);
  return points;
}

TEST(EncodeResultsTest, PacksEachQuantityOfThePart) {
  const PageArray<PointCurvature> points = Points(5);
  curvature::v1::ResultChunk chunk;
  EncodeResults(points, 1, 3, QuantitySet(), &chunk);
  EXPECT_EQ(chunk.first_index(), 1u);
  EXPECT_EQ(chunk.point_count(), 3u);
  EXPECT_EQ(chunk.status(), std::string("\x02\x03\x04"));
  ASSERT_EQ(chunk.mean_curvature().size(), 12u);
  EXPECT_EQ(FloatAt(chunk.mean_curvature(), 0), 101.0f);
  EXPECT_EQ(FloatAt(chunk.gaussian_curvature(), 1), 202.0f);
  EXPECT_EQ(FloatAt(chunk.k1(), 2), 303.0f);
  EXPECT_EQ(FloatAt(chunk.k2(), 0), 104.0f);
  ASSERT_EQ(chunk.d1().size(), 36u);
  EXPECT_EQ(FloatAt(chunk.d1(), 4), 206.0f);
  EXPECT_EQ(FloatAt(chunk.d2(), 8), 310.0f);
  EXPECT_EQ(FloatAt(chunk.radius(), 2), 311.0f);
}

TEST(EncodeResultsTest, LeavesOutWhatWasNotAskedFor) {
  const PageArray<PointCurvature> points = Points(2);
  curvature::v1::ResultChunk chunk;
  EncodeResults(points, 0, 2, QuantitySet(), &chunk);
  EncodeResults(points, 0, 2, {false, true, false, false, false}, &chunk);
  EXPECT_EQ(chunk.status().size(), 2u);
  EXPECT_EQ(chunk.gaussian_curvature().size(), 8u);
  EXPECT_TRUE(chunk.mean_curvature().empty() && chunk.k1().empty() && chunk.k2().empty() && chunk.d1().empty() &&
              chunk.d2().empty() && chunk.radius().empty());
}

TEST(EncodeResultsTest, FillsTheSizeThatIsPromised) {
  const PageArray<PointCurvature> points = Points(kResultChunkPoints);
  curvature::v1::ResultChunk chunk;
  EncodeResults(points, 0, kResultChunkPoints, QuantitySet(), &chunk);
  EXPECT_GE(chunk.ByteSizeLong(), kResultChunkPoints * kResultBytesPerPoint);
  EXPECT_LE(chunk.ByteSizeLong(), kResultChunkPoints * kResultBytesPerPoint + 100);
}

}  // namespace
}  // namespace curvd
