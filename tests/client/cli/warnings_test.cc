// What is said of clouds that were estimated, or refused, and are not as they should be.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "client/io/table_file.h"
#include "tests/client/cli/curv_fixture.h"

namespace curv {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

TEST_F(CurvTest, WarnsOfNormalsThatContradictEachOther) {
  PointTable table = *LoadTable(Cloud());
  for (const char* name : {"nx", "ny", "nz"}) {
    std::vector<float> normals(table.size());
    for (size_t i = 0; i < table.size(); ++i) {
      normals[i] = static_cast<float>((table.Find("x")->At(i) > 0.0 ? -1.0 : 1.0) * table.Find(name)->At(i));
    }
    table.Set({name, std::move(normals)});
  }
  const std::string input = dir_.File("half.ply"), out = dir_.File("out.ply");
  ASSERT_TRUE(SaveTable(table, input).ok());
  const CurvRun marked = RunCurv({"estimate", input, "-o", out, "--summary=json"});
  EXPECT_EQ(marked.exit_code, 0);
  EXPECT_THAT(marked.err, AllOf(HasSubstr("curv: warning: normals point to opposite sides of one surface"),
                                HasSubstr("--orient"), Not(HasSubstr("note"))));
  EXPECT_THAT(marked.out, AllOf(HasSubstr("\"opposed_normals\":"),
                                HasSubstr("\"warnings\":[{\"code\":\"OPPOSED_NORMALS\",\"message\":\"normals"),
                                HasSubstr("\"flipped_patches\":1}")));
  const CurvRun refused = RunCurv({"estimate", input, "-o", out, "--on-opposed-normals=reject"});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.err, AllOf(HasSubstr("INVALID_ARGUMENT"), HasSubstr("--orient does that"),
                                 HasSubstr("--on-opposed-normals=mark")));
  const CurvRun oriented = RunCurv({"estimate", input, "-o", out, "--orient", "--summary=json"});
  EXPECT_EQ(oriented.exit_code, 0) << oriented.err;
  EXPECT_THAT(oriented.err, Not(HasSubstr("warning")));
  EXPECT_THAT(oriented.out, HasSubstr("\"warnings\":[]"));
}

// 40 of 2,000 points are moved off the torus along their normals.
TEST_F(CurvTest, WarnsOfOutliers) {
  PointTable table = *LoadTable(Cloud());
  for (const char* name : {"x", "y", "z"}) {
    std::vector<float> moved(table.size());
    for (size_t i = 0; i < table.size(); ++i) {
      const double off = i % 50 == 0 ? 0.8 : 0.0;
      moved[i] = static_cast<float>(table.Find(name)->At(i) + off * table.Find(std::string("n") + name)->At(i));
    }
    table.Set({name, std::move(moved)});
  }
  const std::string input = dir_.File("stray.ply"), out = dir_.File("out.csv");
  ASSERT_TRUE(SaveTable(table, input).ok());
  const CurvRun run = RunCurv({"estimate", input, "-o", out, "--auto", "--summary=json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, AllOf(HasSubstr("curv: warning: 40 of 2,000 points lie off the surface"),
                             HasSubstr(": try --estimator=auto --k=50")));
  EXPECT_THAT(run.out, AllOf(HasSubstr("\"outlier\":40"), HasSubstr("\"code\":\"OUTLIERS\"")));
  EXPECT_THAT(dir_.Read("out.csv"), HasSubstr(",outlier,"));

  const CurvRun kept = RunCurv({"estimate", input, "-o", out, "--estimator=auto", "--k=50", "--summary=json"});
  ASSERT_EQ(kept.exit_code, 0) << kept.err;
  EXPECT_THAT(kept.err, Not(HasSubstr("lie off the surface"))) << "what the warning says to try";
  EXPECT_THAT(kept.out, HasSubstr("\"outlier\":0"));
}

TEST_F(CurvTest, NotesWhereNothingTellsHowSureValuesAre) {
  const std::string small = dir_.File("small.ply"), out = dir_.File("out.csv");
  ASSERT_EQ(RunCurv({"generate", "sphere", "--points=40", "-o", small}).exit_code, 0);
  const CurvRun unknown = RunCurv({"estimate", small, "-o", out, "--auto", "--also=standard_errors"});
  ASSERT_EQ(unknown.exit_code, 0) << unknown.err;
  EXPECT_THAT(unknown.err, HasSubstr("note: 40 of 40 points with curvature have no standard error (NaN)"));
  const CurvRun known = RunCurv({"estimate", Cloud(), "-o", out, "--auto", "--also=standard_errors"});
  ASSERT_EQ(known.exit_code, 0) << known.err;
  EXPECT_THAT(known.err, Not(HasSubstr("standard error")));
}

TEST_F(CurvTest, RefusalsNameThePointAndTheWayOut) {
  const std::string input = dir_.Write("nan.xyz", "1 2 3 0 0 1\n1 2 nan 0 0 1\n");
  const CurvRun refused = RunCurv({"estimate", input, "-o", dir_.File("out.ply")});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.err, AllOf(HasSubstr("INVALID_ARGUMENT"), HasSubstr("1"), HasSubstr("--on-invalid=skip")));
  EXPECT_EQ(RunCurv({"estimate", input, "-o", dir_.File("out.ply"), "--on-invalid=skip"}).exit_code, 0);
}

TEST_F(CurvTest, SaysWhenNoPointCouldBeEstimated) {
  const CurvRun run = RunCurv({"estimate", Cloud(), "-o", dir_.File("r.ply"), "--k=5000"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.err, HasSubstr("no point has a result; most are too_few_neighbors: neighborhoods of 5,000 points"));
}

TEST_F(CurvTest, TellsHowManyPointsGetNoNormalSinceTheyAreUnusable) {
  const std::string cloud = dir_.Write("holes.csv", "x,y,z,nx,ny,nz\nnan,0,0,0,0,1\n0,0,0,0,0,1\n0,0,1,0,0,0\n");
  EXPECT_THAT(RunCurv({"normals", cloud, "-o", dir_.File("n.ply")}).err,
              HasSubstr("note: 1 point cannot be used (invalid_input): its position, normal or viewpoint"));
  EXPECT_THAT(RunCurv({"orient", cloud, "-o", dir_.File("o.ply")}).err,
              HasSubstr("note: 2 points cannot be used (invalid_input): their position"));
}

TEST_F(CurvTest, NotesWhatItLeavesOut) {
  const CurvRun run =
      RunCurv({"estimate", dir_.Write("o.obj", "v 0 0 0\nv 1 0 0\nvn 0 0 1\n"), "-o", dir_.File("r.csv")});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.err, HasSubstr("note: "));
  EXPECT_THAT(run.err, Not(HasSubstr("terminate")));
}

}  // namespace
}  // namespace curv
