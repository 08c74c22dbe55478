#include "core/job/field_arrays.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "tests/core/numbered_points.h"

namespace curvd {
namespace {

std::vector<PointCurvature> Points(size_t count) {
  std::vector<PointCurvature> points(count);
  for (size_t i = 0; i < count; ++i) points[i] = NumberedPoint(i);
  return points;
}

std::string Packed(const std::vector<PointCurvature>& points, const Column& column) {
  std::string bytes;
  for (const PointCurvature& point : points) {
    bytes.append(reinterpret_cast<const char*>(&point) + column.offset, column.bytes());
  }
  return bytes;
}

// An array without an alignment, and a guard behind it.
struct Guarded {
  explicit Guarded(size_t size) : bytes(1 + size + 16, '#') {}
  char* data() { return bytes.data() + 1; }
  std::string content() const { return bytes.substr(1, bytes.size() - 17); }
  bool whole() const { return bytes.front() == '#' && bytes.substr(bytes.size() - 16) == std::string(16, '#'); }
  std::string bytes;
};

TEST(SplitFieldTest, WritesEachColumnAndNothingElse) {
  for (size_t count = 0; count <= 13; ++count) {
    SCOPED_TRACE(count);
    const std::vector<PointCurvature> points = Points(count);
    std::vector<Guarded> arrays;
    ColumnPlaces places{};
    for (const Column& column : kColumns) arrays.emplace_back(count * column.bytes());
    for (size_t i = 0; i < kColumnCount; ++i) places[i] = arrays[i].data();
    SplitField(points, places);
    for (size_t i = 0; i < kColumnCount; ++i) {
      EXPECT_EQ(arrays[i].content(), Packed(points, kColumns[i])) << kColumns[i].name;
      EXPECT_TRUE(arrays[i].whole()) << kColumns[i].name;
    }
  }
}

TEST(SplitFieldTest, LeavesOutWhatIsNotWanted) {
  const std::vector<PointCurvature> points = Points(6);
  for (size_t i = 0; i < kColumnCount; ++i) {
    Guarded array(kColumns[i].bytes() * points.size());
    ColumnPlaces places{};
    places[i] = array.data();
    SplitField(points, places);
    EXPECT_EQ(array.content(), Packed(points, kColumns[i])) << kColumns[i].name;
    EXPECT_TRUE(array.whole());
  }
}

TEST(ColumnsTest, AreFoundByTheirNames) {
  for (size_t i = 0; i < kColumnCount; ++i) EXPECT_EQ(ColumnIndex(kColumns[i].name), i);
  EXPECT_EQ(ColumnIndex("curl"), kColumnCount);
}

TEST(ColumnsTest, AnUndefinedPointHasNaNInEveryFloat) {
  const PointCurvature point = UndefinedCurvature(PointStatus::kSingularFit);
  EXPECT_EQ(point.status, PointStatus::kSingularFit);
  for (const float value : {point.mean, point.gaussian, point.k1, point.k2, point.d1[2], point.d2[0], point.radius}) {
    EXPECT_TRUE(std::isnan(value));
  }
}

}  // namespace
}  // namespace curvd
