#include "server/call/result_encoder.h"

#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

#include "curvature/v1/curvature.pb.h"
#include "tests/core/numbered_points.h"

namespace curvd {
namespace {

float FloatAt(const std::string& bytes, size_t i) {
  float value = 0.0f;
  std::memcpy(&value, bytes.data() + i * sizeof(float), sizeof(float));
  return value;
}

CallResults Points(size_t count) {
  PageArray<PointCurvature> points = *PageArray<PointCurvature>::Create(count);
  for (size_t i = 0; i < count; ++i) points[i] = NumberedPoint(i);
  return {std::move(points), {}};
}

NormalField Normals(size_t count) {
  NormalField normals = *NormalField::Create(count);
  for (size_t i = 0; i < count; ++i) {
    const auto n = static_cast<float>(1000 * i);
    normals[i] = {{n + 1.0f, n + 2.0f, n + 3.0f}, n + 4.0f, n + 5.0f, PointStatus::kDegenerateArea};
  }
  return normals;
}

QuantitySet Only(curvature::v1::Quantity quantity) {
  QuantitySet set = QuantitySet::None();
  set.Add(quantity);
  return set;
}

std::string Packed(const CallResults& points, size_t first, size_t count, const QuantitySet& quantities) {
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

TEST(PackResultsTest, PacksWhatFollowsFromTheRestWhereItIsAskedFor) {
  CallResults points = Points(3);
  for (size_t i = 0; i < 3; ++i) points.curvature[i].k1 = points.curvature[i].k2 = 2.0f;
  points.curvature[2].k1 = -2.0f;
  QuantitySet both = Only(curvature::v1::QUANTITY_SHAPE_INDEX);
  both.Add(curvature::v1::QUANTITY_CURVEDNESS);
  EXPECT_TRUE(both.HasCurvature());
  const curvature::v1::ResultChunk chunk = Parsed(Packed(points, 1, 2, both));
  ASSERT_EQ(chunk.shape_index().size(), 8u);
  EXPECT_EQ(FloatAt(chunk.shape_index(), 0), 1.0f);
  EXPECT_EQ(FloatAt(chunk.shape_index(), 1), 0.0f);
  EXPECT_EQ(FloatAt(chunk.curvedness(), 0), 2.0f);
  EXPECT_TRUE(chunk.k1().empty());
  EXPECT_FALSE(QuantitySet().Has(curvature::v1::QUANTITY_SHAPE_INDEX));
}

ChoiceField Choices(size_t count) {
  ChoiceField choices = *ChoiceField::Create(count);
  for (size_t i = 0; i < count; ++i) {
    const auto n = static_cast<float>(1000 * i);
    choices[i] = {n + 1.0f, n + 2.0f, n + 3.0f, n + 4.0f, n + 5.0f, n + 6.0f, n + 7.0f, n + 8.0f};
  }
  return choices;
}

TEST(PackResultsTest, PacksHowAnEstimateWasChosenAndHowSureItIs) {
  CallResults points = Points(3);
  points.choices = Choices(3);
  QuantitySet quantities = Only(curvature::v1::QUANTITY_STANDARD_ERRORS);
  EXPECT_TRUE(quantities.HasCurvature() && quantities.HasChoice());
  const curvature::v1::ResultChunk errors = Parsed(Packed(points, 1, 2, quantities));
  ASSERT_EQ(errors.mean_curvature_standard_error().size(), 8u);
  EXPECT_EQ(FloatAt(errors.mean_curvature_standard_error(), 0), 1001.0f);
  EXPECT_EQ(FloatAt(errors.k1_standard_error(), 1), 2002.0f);
  EXPECT_EQ(FloatAt(errors.k2_standard_error(), 0), 1003.0f);
  EXPECT_TRUE(errors.chosen_neighbor_count().empty() && errors.jet_weight().empty());
  quantities = Only(curvature::v1::QUANTITY_CHOSEN_NEIGHBOR_COUNT);
  quantities.Add(curvature::v1::QUANTITY_ESTIMATOR_WEIGHTS);
  const curvature::v1::ResultChunk choices = Parsed(Packed(points, 1, 2, quantities));
  EXPECT_EQ(FloatAt(choices.chosen_neighbor_count(), 0), 1004.0f);
  EXPECT_EQ(FloatAt(choices.avg_hexagram_weight(), 0), 1005.0f);
  EXPECT_EQ(FloatAt(choices.normal_regression_weight(), 0), 1006.0f);
  EXPECT_EQ(FloatAt(choices.jet_weight(), 1), 2007.0f);
  EXPECT_EQ(FloatAt(choices.aso_weight(), 0), 1008.0f);
  EXPECT_TRUE(choices.k1_standard_error().empty());
  EXPECT_FALSE(QuantitySet().HasChoice());
}

TEST(PackResultsTest, PacksNormalCurvatureInOneDirectionOrInThoseOfThePoints) {
  CallResults points = Points(3);
  for (size_t i = 0; i < 3; ++i) {
    points.curvature[i].k1 = -1.0f;
    points.curvature[i].k2 = 2.0f;
    points.curvature[i].d1 = {1.0f, 0.0f, 0.0f};
    points.curvature[i].d2 = {0.0f, 1.0f, 0.0f};
  }
  points.direction = {0.0f, 1.0f, 0.0f};
  const QuantitySet quantities = Only(curvature::v1::QUANTITY_NORMAL_CURVATURE);
  EXPECT_EQ(FloatAt(Parsed(Packed(points, 1, 2, quantities)).normal_curvature(), 1), 2.0f);
  const std::vector<float> each = {1, 0, 0, 0, 5, 0, 3, 0, 0};
  ASSERT_TRUE(
      points.directions
          .Append({{reinterpret_cast<const char*>(each.data()), each.size() * sizeof(float)}}, ScalarType::kFloat32)
          .ok());
  const std::string packed = Parsed(Packed(points, 1, 2, quantities)).normal_curvature();
  EXPECT_EQ(FloatAt(packed, 0), 2.0f);
  EXPECT_EQ(FloatAt(packed, 1), -1.0f);
}

TEST(PackResultsTest, TheBytesAreThoseOfProtobuf) {
  CallResults points = Points(40'000);
  points.normals = Normals(40'000);
  points.choices = Choices(40'000);
  QuantitySet everything;
  everything.Add(curvature::v1::QUANTITY_NORMALS);
  everything.Add(curvature::v1::QUANTITY_NORMAL_QUALITY);
  everything.Add(curvature::v1::QUANTITY_STANDARD_ERRORS);
  everything.Add(curvature::v1::QUANTITY_ESTIMATOR_WEIGHTS);
  everything.Add(curvature::v1::QUANTITY_NORMAL_CURVATURE);
  for (const size_t first : {0, 1, 127, 128, 16'384, 20'000}) {
    for (const size_t count : {1, 4, 31, 32, 127, 128, 5'000, 16'384}) {
      for (const QuantitySet& quantities :
           {QuantitySet(), everything, Only(curvature::v1::QUANTITY_PRINCIPAL_DIRECTIONS),
            Only(curvature::v1::QUANTITY_RADIUS)}) {
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
  const CallResults points = Points(3);
  const curvature::v1::ResultChunk chunk = Parsed(Packed(points, 0, 3, QuantitySet()));
  for (const Column& column : kColumns) {
    const auto* field = curvature::v1::ResultChunk::descriptor()->FindFieldByName(std::string(column.name));
    ASSERT_NE(field, nullptr) << column.name;
    std::string expected;
    for (size_t i = 0; i < 3; ++i) {
      expected.append(reinterpret_cast<const char*>(&points.curvature[i]) + column.offset, column.bytes());
    }
    EXPECT_EQ(chunk.GetReflection()->GetString(chunk, field), expected) << column.name;
  }
}

TEST(PackResultsTest, PacksNormalsBesideCurvature) {
  CallResults results = Points(5);
  results.normals = Normals(5);
  QuantitySet quantities = Only(curvature::v1::QUANTITY_MEAN_CURVATURE);
  quantities.Add(curvature::v1::QUANTITY_NORMALS);
  const curvature::v1::ResultChunk chunk = Parsed(Packed(results, 1, 3, quantities));
  EXPECT_EQ(chunk.status(), std::string("\x02\x03\x04")) << "that of curvature";
  EXPECT_EQ(FloatAt(chunk.mean_curvature(), 0), 101.0f);
  ASSERT_EQ(chunk.normal().size(), 36u);
  EXPECT_EQ(FloatAt(chunk.normal(), 0), 1001.0f);
  EXPECT_EQ(FloatAt(chunk.normal(), 8), 3003.0f);
  EXPECT_TRUE(chunk.normal_residual().empty());
}

TEST(PackResultsTest, PacksNormalsAlone) {
  QuantitySet quantities = Only(curvature::v1::QUANTITY_NORMALS);
  quantities.Add(curvature::v1::QUANTITY_NORMAL_QUALITY);
  const CallResults results = {{}, Normals(2)};
  ASSERT_EQ(results.size(), 2u);
  const curvature::v1::ResultChunk chunk = Parsed(Packed(results, 0, 2, quantities));
  EXPECT_EQ(chunk.status(), std::string("\x03\x03")) << "that of the normal";
  EXPECT_EQ(FloatAt(chunk.normal(), 3), 1001.0f);
  EXPECT_EQ(FloatAt(chunk.normal_residual(), 1), 1004.0f);
  EXPECT_EQ(FloatAt(chunk.normal_variance_ratio(), 0), 5.0f);
  EXPECT_TRUE(chunk.mean_curvature().empty());
}

TEST(PackResultsTest, MessagesStayBelowAMebibyte) {
  QuantitySet everything;
  everything.Add(curvature::v1::QUANTITY_NORMALS);
  everything.Add(curvature::v1::QUANTITY_NORMAL_QUALITY);
  EXPECT_EQ(ResultChunkPoints(QuantitySet()), kResultChunkPoints);
  for (const QuantitySet& quantities : {QuantitySet(), everything}) {
    const size_t points = ResultChunkPoints(quantities);
    CallResults results = Points(points);
    if (quantities.HasNormals()) results.normals = Normals(points);
    const size_t size = Packed(results, 0, points, quantities).size();
    EXPECT_GE(size, points * ResultBytesPerPoint(quantities));
    EXPECT_LE(size, points * ResultBytesPerPoint(quantities) + 100);
    EXPECT_LT(size, size_t{1} << 20);
  }
}

}  // namespace
}  // namespace curvd
