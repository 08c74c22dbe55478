// curv select, the program.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/io/table_file.h"
#include "tests/client/cli/run_curv.h"
#include "tests/client/temp_dir.h"

namespace curv {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(SelectTest, KeepsPointsAndColumns) {
  const TempDir dir;
  const std::string cloud = dir.File("torus.ply"), result = dir.File("result.las"), out = dir.File("out.las");
  ASSERT_EQ(RunCurv({"generate", "torus", "--points=1000", "-o", cloud}).exit_code, 0);
  ASSERT_EQ(RunCurv({"estimate", cloud, "-o", result}).exit_code, 0);
  const CurvRun run = RunCurv({"select", result, "--where", "k1 < 0 and status == ok", "-o", out});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const PointTable all = *LoadTable(result), inner = *LoadTable(out);
  size_t expected = 0;
  for (size_t i = 0; i < all.size(); ++i) expected += all.Find("k1")->At(i) < 0;
  EXPECT_EQ(inner.size(), expected);
  EXPECT_GT(expected, 200u);
  EXPECT_EQ(inner.columns().size(), all.columns().size());
  for (size_t i = 0; i < inner.size(); ++i) EXPECT_LT(inner.Find("k1")->At(i), 0.0);
  EXPECT_THAT(run.out, HasSubstr(" of 1,000 points"));
  const CurvRun piped = RunCurv({"select", "-", "--format=ply", "--where=x > 0", "-o", "-"}, cloud);
  EXPECT_EQ(piped.exit_code, 0) << piped.err;
  EXPECT_THAT(piped.err, HasSubstr(" of 1,000 points"));
}

TEST(SelectTest, StatusesOfScalesHaveWords) {
  const TempDir dir;
  const std::string cloud = dir.File("torus.ply"), out = dir.File("out.csv");
  ASSERT_EQ(RunCurv({"generate", "torus", "--points=40", "-o", cloud}).exit_code, 0);
  for (const char* name : {"scales.ply", "scales.csv"}) {
    const std::string scales = dir.File(name);
    ASSERT_EQ(RunCurv({"estimate", cloud, "-o", scales, "--k=16,50"}).exit_code, 0);
    const CurvRun run =
        RunCurv({"select", scales, "--where=status_k16 == ok and status_k50 == too_few_neighbors", "-o", out});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_THAT(run.out, HasSubstr("40 of 40 points"));
  }
  EXPECT_THAT(dir.Read("scales.csv"), AllOf(HasSubstr(",ok,"), HasSubstr(",too_few_neighbors,")));
}

TEST(SelectTest, SaysWhatIsWrong) {
  const TempDir dir;
  const std::string cloud = dir.Write("a.xyz", "1 2 3 0 0 1\n"), out = dir.File("out.ply");
  const CurvRun unknown = RunCurv({"select", cloud, "--where", "k2 > 0", "-o", out});
  EXPECT_EQ(unknown.exit_code, 3) << "the input lacks what is needed, as for curv render";
  EXPECT_EQ(RunCurv({"select", cloud, "--where", "k2 >", "-o", out}).exit_code, 3);
  EXPECT_EQ(RunCurv({"select", cloud, "--where", "x >", "-o", out}).exit_code, 2);
  EXPECT_THAT(unknown.err,
              HasSubstr("a.xyz: --where: character 1: there is no column \"k2\". The columns are: x y z nx ny nz"));
  const CurvRun none = RunCurv({"select", cloud, "--where", "x > 1", "-o", out});
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.err, HasSubstr("holds for none of 1 point:"));
  EXPECT_EQ(RunCurv({"select", cloud, "-o", out}).exit_code, 2);
  EXPECT_EQ(RunCurv({"select", dir.File("none.ply"), "--where=x>0", "-o", out}).exit_code, 3);
  EXPECT_EQ(RunCurv({"select", cloud, "--where=x>0", "-o", dir.File("out.doc")}).exit_code, 4);
  EXPECT_FALSE(dir.Has("out.ply"));
}

TEST(SelectTest, TellsTheImpatientWhatToWrite) {
  const TempDir dir;
  const std::string cloud = dir.Write("a.csv", "x,y,z,\u03ba\n1,2,3,4\n"), out = dir.File("o.csv");
  const auto message = [&](const std::vector<std::string>& words) { return RunCurv(words).err; };
  EXPECT_THAT(message({"select", cloud, "--where=\u03ba > 1", "-o", out}), HasSubstr("stand in double quotes"));
  EXPECT_EQ(RunCurv({"select", cloud, "--where=\"\u03ba\" > 1", "-o", out}).exit_code, 0);
  EXPECT_THAT(message({"select", cloud, "--where=x == 'ok'", "-o", out}), HasSubstr("without single quotes"));
  EXPECT_THAT(message({"select", dir.File(""), "--where=x > 0", "-o", out}),
              HasSubstr("is a directory: name the files"));
  EXPECT_THAT(message({"select", cloud, "--where=x > 0", "-o", dir.File("")}), HasSubstr("the output must be a file"));
}

TEST(SelectTest, NamesPropertiesForOtherPrograms) {
  const TempDir dir;
  const std::string cloud = dir.Write("a.csv", "x,y,z,nx,ny,nz,mean_curvature,k1,status\n1,2,3,0,0,1,0.5,0.25,ok\n");
  const auto header = [&](const std::string& names) {
    const std::string out = dir.File(names + ".ply");
    const CurvRun run = RunCurv({"select", cloud, "--where=x > 0", "-o", out, "--names=" + names});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    const std::string file = dir.Read(names + ".ply");
    return file.substr(0, file.find("end_header"));
  };
  EXPECT_THAT(header("cloudcompare"),
              AllOf(HasSubstr(" nx\n"), HasSubstr(" scalar_mean_curvature\n"), HasSubstr(" scalar_status\n")));
  EXPECT_THAT(header("meshlab"), AllOf(HasSubstr(" quality\n"), HasSubstr(" k1\n"), Not(HasSubstr("mean_curvature"))));
  const PointTable back = *LoadTable(dir.File("cloudcompare.ply"));
  EXPECT_EQ(back.Find("k1")->At(0), 0.25);
  EXPECT_EQ(back.Find("status")->At(0), 1.0);
  const CurvRun las = RunCurv({"select", cloud, "--where=x > 0", "-o", dir.File("o.las"), "--names=meshlab"});
  EXPECT_EQ(las.exit_code, 2);
  EXPECT_THAT(las.err, HasSubstr("the output must be .ply"));
}

TEST(SelectTest, TextIsRefusedOfFormatsWithoutIt) {
  const TempDir dir;
  const CurvRun run = RunCurv({"select", dir.File("absent.ply"), "--where=x > 0", "-o", dir.File("o.npz"), "--ascii"});
  EXPECT_EQ(run.exit_code, 2) << "before the input is looked for";
  EXPECT_THAT(run.err, HasSubstr("o.npz: --ascii: .npz has no form of text"));
}

TEST(SelectTest, KeepsTheFrameOfPcdOrSaysThatItIsLost) {
  const TempDir dir;
  const std::string frame = "WIDTH 2\nHEIGHT 2\nVIEWPOINT 0 0 5 0 1 0 0\n";
  const std::string cloud = dir.Write(
      "grid.pcd", "FIELDS x rgb\nSIZE 4 4\nTYPE F U\n" + frame + "POINTS 4\nDATA ascii\n1 255\n2 0\n3 0\n4 0\n");
  const CurvRun all = RunCurv({"select", cloud, "--where=x > 0", "-o", dir.File("all.pcd"), "--ascii"});
  EXPECT_EQ(all.err, "");
  EXPECT_THAT(dir.Read("all.pcd"), HasSubstr(frame));
  ASSERT_EQ(RunCurv({"select", cloud, "--where=blue == 0", "-o", dir.File("some.pcd")}).exit_code, 0);
  EXPECT_THAT(dir.Read("some.pcd"), HasSubstr("WIDTH 3\nHEIGHT 1\nVIEWPOINT 0 0 5 0 1 0 0\n"));
  EXPECT_THAT(RunCurv({"select", cloud, "--where=x > 0", "-o", dir.File("all.ply")}).err,
              HasSubstr("all.ply: left out the viewpoint 0,0,5 and the grid of 2 x 2 points"));
}

}  // namespace
}  // namespace curv
