// LAS files through the program: from LAS to LAS, and to PLY and back.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "client/io/las/las_frame.h"
#include "client/io/las/laz_points.h"
#include "client/io/table_file.h"
#include "tests/client/cli/run_curv.h"
#include "tests/client/io/las/las_samples.h"
#include "tests/client/io/samples.h"
#include "tests/client/temp_dir.h"

namespace curv {
namespace {

using ::testing::HasSubstr;

// A hilly terrain of 1,600 points in UTM coordinates, whose steps are millimeters; seen from above, as LAS files are.
SampleLas Terrain(int format) {
  SampleLas las = SmallLas(format);
  las.scale[0] = las.scale[1] = las.scale[2] = 0.001;
  las.records = {{"LASF_Projection", 2112, "PROJCS[\"UTM\"]"}};
  las.points.clear();
  for (int i = 0; i < 1600; ++i) {
    const double x = (i % 40) * 0.5 + 0.11 * std::sin(i), y = (i / 40) * 0.5 + 0.11 * std::cos(3 * i);
    const double z = 2 * std::sin(x / 4) * std::cos(y / 5);
    std::string point = SamplePoint(format, i % 20);
    const std::string raw =
        Pack(static_cast<int32_t>(1000 * x), static_cast<int32_t>(1000 * y), static_cast<int32_t>(1000 * z));
    las.points.push_back(point.replace(0, raw.size(), raw));
  }
  return las;
}

PointTable Load(const std::string& path) {
  absl::StatusOr<PointTable> table = LoadTable(path);
  EXPECT_TRUE(table.ok()) << table.status();
  return table.ok() ? *std::move(table) : PointTable();
}

// Whether all columns of `expected` are in `actual`, bit by bit, NaN included.
void ExpectHolds(const PointTable& actual, const PointTable& expected) {
  for (const Column& column : expected.columns()) {
    const Column* const other = actual.Find(column.name);
    ASSERT_NE(other, nullptr) << column.name;
    EXPECT_EQ(other->kind(), column.kind()) << column.name;
    for (size_t i = 0; i < column.size(); ++i) {
      const double a = column.At(i), b = other->At(i);
      ASSERT_TRUE(a == b || (std::isnan(a) && std::isnan(b)))
          << column.name << " of point " << i << ": " << a << ", " << b;
    }
  }
}

TEST(CurvLasTest, EstimatesInLasWhatItEstimatesInPly) {
  const TempDir dir;
  for (const int format : {0, 3, 6, 7}) {
    const std::string las = dir.Write("in.las", Terrain(format).Bytes()), ply = dir.File("in.ply");
    const PointTable in = Load(las);
    ASSERT_TRUE(SaveTable(in, ply).ok());
    const CurvRun run = RunCurv({"estimate", las, "-o", dir.File("out.las"), "--normals=estimate", "--up"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(run.err, "");
    ASSERT_EQ(RunCurv({"estimate", ply, "-o", dir.File("out.ply"), "--normals=estimate", "--up"}).exit_code, 0);
    const PointTable out = Load(dir.File("out.las"));
    ExpectHolds(out, Load(dir.File("out.ply")));
    ExpectHolds(out, in);
    EXPECT_EQ(out.las->axes[0].scale, 0.001);
    ASSERT_EQ(out.las->records.size(), 1u);
    EXPECT_EQ(out.las->records[0].payload, "PROJCS[\"UTM\"]");
    EXPECT_NE(out.Find("gaussian_curvature"), nullptr);
    EXPECT_EQ(out.las->point_format, format);
  }
}

TEST(CurvLasTest, WritesNormalsAndReadsThem) {
  const TempDir dir;
  const std::string las = dir.Write("in.las", Terrain(6).Bytes());
  const CurvRun run = RunCurv({"normals", las, "-o", dir.File("normals.las"), "--up"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(dir.Read("normals.las"), HasSubstr("normal_z"));
  const PointTable normals = Load(dir.File("normals.las"));
  for (size_t i = 0; i < normals.size(); ++i) EXPECT_GT(normals.Find("nz")->At(i), 0.0);
  ASSERT_EQ(RunCurv({"estimate", dir.File("normals.las"), "-o", dir.File("given.las")}).exit_code, 0);
  ASSERT_EQ(RunCurv({"normals", las, "-o", dir.File("normals.ply"), "--up"}).exit_code, 0);
  ASSERT_EQ(RunCurv({"estimate", dir.File("normals.ply"), "-o", dir.File("given.ply")}).exit_code, 0);
  ExpectHolds(Load(dir.File("given.las")), Load(dir.File("given.ply")));
}

TEST(CurvLasTest, GoesToPlyAndBack) {
  const TempDir dir;
  ASSERT_EQ(RunCurv({"generate", "torus", "--points=2000", "-o", dir.File("torus.las")}).exit_code, 0);
  ASSERT_EQ(RunCurv({"estimate", dir.File("torus.las"), "-o", dir.File("out.ply")}).exit_code, 0);
  ASSERT_EQ(RunCurv({"estimate", dir.File("out.ply"), "-o", dir.File("back.las"), "--color"}).exit_code, 0);
  const PointTable ply = Load(dir.File("out.ply")), las = Load(dir.File("back.las"));
  EXPECT_EQ(Values(las, "mean_curvature"), Values(ply, "mean_curvature"));
  EXPECT_EQ(Values(las, "x"), Values(ply, "x"));
  EXPECT_EQ(las.las->point_format, 7) << "which has colors";
}

TEST(CurvLasTest, EstimatesWhatPdalWrote) {
  const TempDir dir;
  for (const char* name : {"terrain_3.las", "terrain_7.las"}) {
    const std::string las = std::string(PDAL_FILES) + "/" + name, ply = dir.File("in.ply");
    const PointTable in = Load(las);
    ASSERT_TRUE(SaveTable(in, ply).ok());
    const CurvRun run = RunCurv({"estimate", las, "-o", dir.File("out.las"), "--k=20"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    ASSERT_EQ(RunCurv({"estimate", ply, "-o", dir.File("out.ply"), "--k=20"}).exit_code, 0);
    const PointTable out = Load(dir.File("out.las"));
    ExpectHolds(out, Load(dir.File("out.ply")));
    ExpectHolds(out, in);
    EXPECT_EQ(out.las->records.size(), in.las->records.size()) << "coordinate systems";
  }
}

TEST(CurvLasTest, NamesRemediesOfWhatItDoesNotRead) {
  if (CanReadLaz()) GTEST_SKIP() << "built with lazperf";
  const TempDir dir;
  std::string laz = Terrain(0).Bytes();
  laz[104] = static_cast<char>(128);
  for (const char* name : {"a.laz", "a.copc.laz", "a.las"}) {
    const CurvRun run = RunCurv({"estimate", dir.Write(name, laz), "-o", dir.File("o.ply")});
    EXPECT_EQ(run.exit_code, 3);
    EXPECT_THAT(run.err, HasSubstr("laszip -i in.laz -o out.las"));
  }
  const CurvRun e57 = RunCurv({"estimate", dir.Write("a.e57", "ASTM-E57"), "-o", dir.File("o.ply")});
  EXPECT_EQ(e57.exit_code, 3);
  EXPECT_THAT(e57.err, HasSubstr("pdal translate in.e57 out.las"));
}

}  // namespace
}  // namespace curv
