// Clouds without normals, and what makes or turns them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/io/table_file.h"
#include "tests/client/cli/curv_fixture.h"

namespace curv {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST_F(CurvTest, OrientsNormals) {
  const std::string cloud = Cloud("sphere", "1000");
  PointTable table = *LoadTable(cloud);
  for (const char* name : {"nx", "ny", "nz"}) {
    Column column = *table.Find(name);
    auto& values = std::get<std::vector<float>>(column.values);
    for (size_t i = 0; i < values.size(); i += 3) values[i] = -values[i];
    table.Set(std::move(column));
  }
  const std::string mixed = dir_.File("mixed.ply");
  ASSERT_TRUE(SaveTable(table, mixed).ok());
  const CurvRun orient = RunCurv({"orient", mixed, "-o", dir_.File("oriented.ply")});
  ASSERT_EQ(orient.exit_code, 0) << orient.err;
  EXPECT_THAT(orient.out, HasSubstr("negated 334 of 1,000 normals"));
  EXPECT_EQ(dir_.Read("oriented.ply"), dir_.Read("sphere.ply"));

  EXPECT_THAT(RunCurv({"estimate", mixed, "-o", dir_.File("a.ply")}).err, HasSubstr("--orient"));
  ASSERT_EQ(RunCurv({"estimate", mixed, "-o", dir_.File("a.ply"), "--orient"}).exit_code, 0);
  ASSERT_EQ(RunCurv({"estimate", cloud, "-o", dir_.File("b.ply")}).exit_code, 0);
  EXPECT_EQ(dir_.Read("a.ply"), dir_.Read("b.ply"));
}

// A file of the cloud's positions alone, as rows of text, with `columns` of constants behind them.
std::string Positions(const TempDir& dir, const std::string& name, const PointTable& table,
                      const char* constants = "") {
  std::string rows = *constants == '\0' ? "x,y,z\n" : "x,y,z,vp_x,vp_y,vp_z\n";
  for (size_t i = 0; i < table.size(); ++i) {
    absl::StrAppend(&rows, table.Find("x")->At(i), ",", table.Find("y")->At(i), ",", table.Find("z")->At(i), constants,
                    "\n");
  }
  return dir.Write(name, rows);
}

// How many normals of `made` point to the side of those of `truth`.
size_t RightSides(const PointTable& made, const PointTable& truth) {
  size_t right = 0;
  for (size_t i = 0; i < made.size(); ++i) {
    double agreement = 0.0;
    for (const char* name : {"nx", "ny", "nz"}) agreement += made.Find(name)->At(i) * truth.Find(name)->At(i);
    right += agreement > 0.0 ? 1 : 0;
  }
  return right;
}

TEST_F(CurvTest, EstimatesACloudWithoutNormals) {
  const PointTable sphere = *LoadTable(Cloud("sphere", "5000"));
  const std::string bare = Positions(dir_, "bare.csv", sphere), out = dir_.File("out.ply");
  const CurvRun refused = RunCurv({"estimate", bare, "-o", out});
  EXPECT_EQ(refused.exit_code, 3);
  EXPECT_THAT(refused.err, AllOf(HasSubstr("no normals"), HasSubstr("--normals=estimate")));

  const CurvRun run = RunCurv({"estimate", bare, "-o", out, "--normals=estimate"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("normals by jet-"), HasSubstr("1 piece, closed, certificate"),
                             HasSubstr(" normals "), HasSubstr(" orientation ")));
  const PointTable result = *LoadTable(out);
  EXPECT_EQ(ColumnNames(result)[3], "nx");
  EXPECT_EQ(RightSides(result, sphere), 5000u);
  EXPECT_NEAR(result.Find("mean_curvature")->At(7), 1.0, 0.05);

  const CurvRun json = RunCurv({"estimate", bare, "-o", out, "--normals=estimate", "--quantities=mean", "--normal-k=20",
                                "--normal-method=pca", "--closed", "--summary=json"});
  ASSERT_EQ(json.exit_code, 0) << json.err;
  EXPECT_THAT(json.out, HasSubstr("\"normals\":{\"method\":\"pca\",\"neighbor_count\":20,"));
  EXPECT_EQ(ColumnNames(*LoadTable(out)),
            (std::vector<std::string>{"x", "y", "z", "nx", "ny", "nz", "mean_curvature", "status"}));
}

TEST_F(CurvTest, WritesNormalsAlone) {
  const PointTable torus = *LoadTable(Cloud("torus", "5000"));
  const std::string bare = Positions(dir_, "bare.csv", torus), out = dir_.File("out.ply");
  const CurvRun run = RunCurv({"normals", bare, "-o", out});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("out.ply: 5,000 points, normals by"), HasSubstr("certificate")));
  const PointTable result = *LoadTable(out);
  EXPECT_EQ(ColumnNames(result), (std::vector<std::string>{"x", "y", "z", "nx", "ny", "nz", "normal_residual",
                                                           "normal_variance_ratio", "status"}));
  EXPECT_EQ(RightSides(result, torus), 5000u);
  EXPECT_EQ(RunCurv({"estimate", out, "-o", dir_.File("curvature.ply")}).exit_code, 0);
  EXPECT_THAT(RunCurv({"normals", bare, "-o", out, "--method=jet-2", "--k=20", "--summary=json"}).out,
              AllOf(HasSubstr("\"method\":\"jet-2\",\"neighbor_count\":20"), HasSubstr("\"warnings\":[]")));
}

TEST_F(CurvTest, SidesFollowFlagsThenTheFile) {
  const PointTable plane = *LoadTable(Cloud("plane", "1000"));  // normals along z
  const std::string bare = Positions(dir_, "bare.csv", plane), out = dir_.File("out.ply");
  const auto right = [&](const std::string& file, const std::vector<std::string>& flags) {
    std::vector<std::string> words = {"normals", file, "-o", out, "--k=12"};
    words.insert(words.end(), flags.begin(), flags.end());
    const CurvRun run = RunCurv(words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return RightSides(*LoadTable(out), plane);
  };
  EXPECT_EQ(right(bare, {"--up"}), 1000u);
  EXPECT_EQ(right(bare, {"--up=-z"}), 0u);
  EXPECT_EQ(right(bare, {"--up=0.1,0,-1"}), 0u);
  EXPECT_EQ(right(bare, {"--viewpoint=0,0,-9"}), 0u);
  const std::string seen = Positions(dir_, "seen.csv", plane, ",0,0,-9");
  EXPECT_EQ(right(seen, {}), 0u);
  EXPECT_EQ(right(seen, {"--up"}), 1000u) << "flags win";
  EXPECT_EQ(right(seen, {"--consistent"}), 1000u);
  EXPECT_THAT(RunCurv({"normals", seen, "-o", out}).err, HasSubstr("the columns vp_x vp_y vp_z"));

  std::string pcd = "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1000\nHEIGHT 1\n";
  absl::StrAppend(&pcd, "VIEWPOINT 0 0 -9 1 0 0 0\nPOINTS 1000\nDATA ascii\n");
  for (size_t i = 0; i < 1000; ++i) {
    absl::StrAppend(&pcd, plane.Find("x")->At(i), " ", plane.Find("y")->At(i), " ", plane.Find("z")->At(i), "\n");
  }
  const std::string file = dir_.Write("seen.pcd", pcd);
  EXPECT_EQ(right(file, {}), 0u);
  EXPECT_THAT(RunCurv({"normals", file, "-o", out}).err, HasSubstr("the viewpoint of the file, 0,0,-9"));
}

TEST_F(CurvTest, FlagsOfNormalsThatMakeNoSenseAreRefused) {
  const std::string cloud = Cloud(), out = dir_.File("out.ply");
  const auto message = [&](std::vector<std::string> flags) {
    std::vector<std::string> words = {"estimate", cloud, "-o", out};
    words.insert(words.end(), flags.begin(), flags.end());
    const CurvRun run = RunCurv(words);
    EXPECT_EQ(run.exit_code, 2) << run.err;
    return run.err;
  };
  EXPECT_THAT(message({"--normals=guess"}), AllOf(HasSubstr("guess"), HasSubstr("orient")));
  EXPECT_THAT(message({"--up"}), HasSubstr("--normals=orient or --normals=estimate"));
  EXPECT_THAT(message({"--normals=orient", "--normal-k=20"}), HasSubstr("need --normals=estimate"));
  EXPECT_THAT(message({"--normals=estimate", "--normal-k=3"}), AllOf(HasSubstr("\"3\""), HasSubstr("auto")));
  EXPECT_THAT(message({"--normals=estimate", "--normal-k=auto", "--normal-radius=1"}), HasSubstr("--normal-k"));
  EXPECT_THAT(message({"--normals=estimate", "--viewpoint=1,2"}), HasSubstr("three finite numbers"));
  EXPECT_THAT(message({"--normals=estimate", "--viewpoint=1,nan,2"}), HasSubstr("1,nan,2"));
  EXPECT_THAT(message({"--normals=estimate", "--up=0,0,0"}), HasSubstr("not all 0"));
  EXPECT_THAT(message({"--normals=estimate", "--up", "--closed"}), HasSubstr("excludes"));
  EXPECT_THAT(message({"--orient", "--normals=given"}), HasSubstr("excludes"));
}

TEST_F(CurvTest, NewNormalsReplaceThoseOfEverySpelling) {
  const std::string cloud = Cloud("torus", "500");
  ASSERT_EQ(RunCurv({"select", cloud, "--where", "x == x", "-o", dir_.File("in.csv")}).exit_code, 0);
  std::string csv = dir_.Read("in.csv");
  for (const char* axis : {"x", "y", "z"}) {
    csv.replace(csv.find(std::string("n") + axis), 2, std::string("Normal_") + axis);
  }
  const CurvRun run = RunCurv({"normals", dir_.Write("in.csv", csv), "-o", dir_.File("out.pcd"), "--ascii"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(dir_.Read("out.pcd"), HasSubstr("FIELDS x y z normal_x normal_y normal_z normal_residual"));
  const absl::StatusOr<PointTable> read = LoadTable(dir_.File("out.pcd"));
  EXPECT_TRUE(read.ok()) << read.status();
}

}  // namespace
}  // namespace curv
