#include "core/job/field_arrays.h"

#include <gtest/gtest.h>

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

template <typename Field>
std::string Packed(const std::vector<PointCurvature>& points, Field PointCurvature::*field) {
  std::string bytes;
  for (const PointCurvature& point : points) {
    bytes.append(reinterpret_cast<const char*>(&(point.*field)), sizeof(Field));
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

TEST(SplitFieldTest, WritesEachQuantityAndNothingElse) {
  for (size_t count = 0; count <= 13; ++count) {
    SCOPED_TRACE(count);
    const std::vector<PointCurvature> points = Points(count);
    Guarded mean(4 * count), gaussian(4 * count), k1(4 * count), k2(4 * count), d1(12 * count), d2(12 * count),
        radius(4 * count), status(count);
    SplitField(points, {mean.data(), gaussian.data(), k1.data(), k2.data(), d1.data(), d2.data(), radius.data(),
                        status.data()});
    EXPECT_EQ(mean.content(), Packed(points, &PointCurvature::mean));
    EXPECT_EQ(gaussian.content(), Packed(points, &PointCurvature::gaussian));
    EXPECT_EQ(k1.content(), Packed(points, &PointCurvature::k1));
    EXPECT_EQ(k2.content(), Packed(points, &PointCurvature::k2));
    EXPECT_EQ(d1.content(), Packed(points, &PointCurvature::d1));
    EXPECT_EQ(d2.content(), Packed(points, &PointCurvature::d2));
    EXPECT_EQ(radius.content(), Packed(points, &PointCurvature::radius));
    EXPECT_EQ(status.content(), Packed(points, &PointCurvature::status));
    for (const Guarded* array : {&mean, &gaussian, &k1, &k2, &d1, &d2, &radius, &status}) EXPECT_TRUE(array->whole());
  }
}

TEST(SplitFieldTest, LeavesOutWhatIsNotWanted) {
  const std::vector<PointCurvature> points = Points(6);
  Guarded d2(12 * points.size());
  SplitField(points, {.d2 = d2.data()});
  EXPECT_EQ(d2.content(), Packed(points, &PointCurvature::d2));
  EXPECT_TRUE(d2.whole());
}

}  // namespace
}  // namespace curvd
