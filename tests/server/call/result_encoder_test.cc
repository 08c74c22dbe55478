#include "server/call/result_encoder.h"

#include <gtest/gtest.h>

#include <cstring>
#include <string>

#include "curvature/v1/curvature.pb.h"
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

QuantitySet Only(curvature::v1::Quantity quantity) {
  QuantitySet set = QuantitySet::None();
  set.Add(quantity);
  return set;
}

std::string Packed(const PageArray<PointCurvature>& points, size_t first, size_t count, const QuantitySet& quantities) {
  const grpc::Slice message = *PackResults(points, first, count, quantities);
  return {reinterpret_cast<const char*>(message.begin()), message.size()};
}

curvature::v1::ResultChunk Parsed(const std::string& message) {
  curvature::v1::EstimateCurvatureResponse response;
  EXPECT_TRUE(response.ParseFromString(message));
  EXPECT_TRUE(response.has_result());
  return response.result();
}

TEST(PackResultsTest, PacksEachQuantityOfThePart) {
  const curvature::v1::ResultChunk chunk = Parsed(Packed(Points(5), 1, 3, QuantitySet()));
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

TEST(PackResultsTest, LeavesOutWhatWasNotAskedFor) {
  const curvature::v1::ResultChunk chunk =
      Parsed(Packed(Points(2), 0, 2, Only(curvature::v1::QUANTITY_GAUSSIAN_CURVATURE)));
  EXPECT_EQ(chunk.status().size(), 2u);
  EXPECT_EQ(chunk.gaussian_curvature().size(), 8u);
  EXPECT_TRUE(chunk.mean_curvature().empty() && chunk.k1().empty() && chunk.k2().empty() && chunk.d1().empty() &&
              chunk.d2().empty() && chunk.radius().empty());
}

TEST(PackResultsTest, TheBytesAreThoseOfProtobuf) {
  const PageArray<PointCurvature> points = Points(40'000);
  for (const size_t first : {0, 1, 127, 128, 16'384, 20'000}) {
    for (const size_t count : {1, 4, 31, 32, 127, 128, 5'000, 16'384}) {
      for (const QuantitySet& quantities :
           {QuantitySet(), Only(curvature::v1::QUANTITY_PRINCIPAL_DIRECTIONS), Only(curvature::v1::QUANTITY_RADIUS)}) {
        const std::string packed = Packed(points, first, count, quantities);
        curvature::v1::EstimateCurvatureResponse response;
        ASSERT_TRUE(response.ParseFromString(packed));
        EXPECT_EQ(response.result().first_index(), first);
        EXPECT_EQ(response.result().point_count(), count);
        EXPECT_EQ(response.SerializeAsString(), packed) << first << " + " << count;
      }
    }
  }
}

TEST(PackResultsTest, EveryColumnOfTheCoreGoesIntoTheFieldOfItsName) {
  const PageArray<PointCurvature> points = Points(3);
  const curvature::v1::ResultChunk chunk = Parsed(Packed(points, 0, 3, QuantitySet()));
  for (const Column& column : kColumns) {
    const auto* field = curvature::v1::ResultChunk::descriptor()->FindFieldByName(std::string(column.name));
    ASSERT_NE(field, nullptr) << column.name;
    std::string expected;
    for (size_t i = 0; i < 3; ++i) {
      expected.append(reinterpret_cast<const char*>(&points[i]) + column.offset, column.bytes());
    }
    EXPECT_EQ(chunk.GetReflection()->GetString(chunk, field), expected) << column.name;
  }
}

TEST(PackResultsTest, HasTheSizeThatIsPromised) {
  const size_t size = Packed(Points(kResultChunkPoints), 0, kResultChunkPoints, QuantitySet()).size();
  EXPECT_GE(size, kResultChunkPoints * kResultBytesPerPoint);
  EXPECT_LE(size, kResultChunkPoints * kResultBytesPerPoint + 100);
}

}  // namespace
}  // namespace curvd
