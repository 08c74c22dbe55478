// What results hold, and what is said of it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/strings/str_cat.h"
#include "client/io/table_file.h"
#include "tests/client/cli/curv_fixture.h"

namespace curv {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::IsSupersetOf;
using ::testing::Not;
using ::testing::StartsWith;

TEST_F(CurvTest, WritesTheQuantitiesThatAreAskedFor) {
  const std::string two = dir_.Write("two.xyz", "0 0 0 0 0 1\n1 0 0 0 0 1\n");
  const std::pair<const char*, const char*> kHeaders[] = {
      {"mean", "x,y,z,nx,ny,nz,mean_curvature,status\n"},
      {"d1,gaussian,gaussian_curvature", "x,y,z,nx,ny,nz,gaussian_curvature,d1x,d1y,d1z,d2x,d2y,d2z,status\n"},
      {"principal_curvatures,radius", "x,y,z,nx,ny,nz,k1,k2,radius,status\n"}};
  for (const auto& [quantities, header] : kHeaders) {
    const CurvRun run = RunCurv({"estimate", two, "-o", dir_.File("q.csv"), absl::StrCat("--quantities=", quantities)});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_THAT(dir_.Read("q.csv"), StartsWith(header));
  }
}

TEST_F(CurvTest, TheListOfQuantitiesEndsBeforeTheInput) {
  const std::string two = dir_.Write("two.xyz", "0 0 0 0 0 1\n1 0 0 0 0 1\n"), out = dir_.File("q.csv");
  const std::vector<std::vector<std::string>> orders = {{"estimate", "--quantities=mean,k1", two, "-o", out},
                                                        {"estimate", "--quantities", "mean,k1", two, "-o", out},
                                                        {"estimate", two, "-o", out, "--quantities", "mean,k1"}};
  for (const std::vector<std::string>& words : orders) {
    const CurvRun run = RunCurv(words);
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_THAT(dir_.Read("q.csv"), StartsWith("x,y,z,nx,ny,nz,mean_curvature,k1,k2,status\n"));
  }
}

TEST_F(CurvTest, SummariesWithoutRangesHaveNone) {
  std::vector<std::string> words = {"estimate", Cloud(), "-o", dir_.File("r.ply"), "--quantities=radius"};
  const CurvRun text = RunCurv(words);
  ASSERT_EQ(text.exit_code, 0) << text.err;
  EXPECT_THAT(text.out, Not(HasSubstr("median")));
  words.push_back("--summary=json");
  EXPECT_THAT(RunCurv(words).out, HasSubstr("\"ranges\":{},"));
}

TEST_F(CurvTest, SummariesOfNormalsAloneNameNoEstimator) {
  const std::vector<std::string> words = {"estimate", Cloud(), "-o", dir_.File("r.ply"), "--quantities=normals"};
  const CurvRun run = RunCurv(words);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("2,000 points, server embedded\n"));
}

TEST_F(CurvTest, ReplacesColumnsOfAnEarlierResult) {
  const std::string once = dir_.File("once.ply"), twice = dir_.File("twice.ply");
  ASSERT_EQ(RunCurv({"estimate", Cloud(), "-o", once}).exit_code, 0);
  ASSERT_EQ(RunCurv({"estimate", once, "-o", twice}).exit_code, 0);
  EXPECT_EQ(dir_.Read("once.ply"), dir_.Read("twice.ply"));
}

TEST_F(CurvTest, NamesTheColumnsThatResultsReplace) {
  const std::string cloud = dir_.Write("c.csv",
                                       "x,y,z,nx,ny,nz,k1,intensity,status_k16,mean_curvature\n"
                                       "0,0,0,0,0,1,7,8,1,9\n1,0,0,0,0,1,7,8,1,9\n");
  constexpr char kNote[] = "c.csv: left out columns that are named like results: k1, status_k16, mean_curvature\n";
  EXPECT_THAT(RunCurv({"estimate", cloud, "-o", dir_.File("r.csv"), "--quantities=gaussian"}).err, HasSubstr(kNote));
  EXPECT_THAT(dir_.Read("r.csv"), StartsWith("x,y,z,nx,ny,nz,gaussian_curvature,status,intensity\n"));
  EXPECT_THAT(RunCurv({"normals", cloud, "-o", dir_.File("n.csv")}).err, HasSubstr(kNote));
  // orient keeps all columns.
  EXPECT_THAT(RunCurv({"orient", cloud, "-o", dir_.File("o.csv")}).err, Not(HasSubstr("left out")));
  EXPECT_THAT(dir_.Read("o.csv"), StartsWith("x,y,z,nx,ny,nz,k1,intensity,status_k16,mean_curvature\n"));
}

TEST_F(CurvTest, DropsWhatAnEarlierResultHasBesideTheQuantitiesAskedFor) {
  const std::string once = dir_.File("once.ply"), twice = dir_.File("twice.ply");
  ASSERT_EQ(RunCurv({"estimate", Cloud(), "-o", once, "--color"}).exit_code, 0);
  const CurvRun run = RunCurv({"estimate", once, "-o", twice, "--quantities=k1,k2", "--k=150"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("k1"), Not(HasSubstr("mean_curvature"))));
  const std::vector<std::string> names = ColumnNames(*LoadTable(twice));
  EXPECT_THAT(names, IsSupersetOf({"nz", "k1", "k2", "status", "true_mean", "red"}));
  for (const char* gone :
       {"mean_curvature", "gaussian_curvature", "d1x", "d1y", "d1z", "d2x", "d2y", "d2z", "radius"}) {
    EXPECT_THAT(names, Not(Contains(gone)));
  }
}

TEST_F(CurvTest, WritesHowSureValuesAreAndWhatWasChosen) {
  const std::string cloud = Cloud("sphere", "3000"), out = dir_.File("sure.csv");
  const CurvRun run = RunCurv({"estimate", cloud, "-o", out, "--auto", "--quantities=mean",
                               "--also=standard_errors,chosen_neighbor_count,estimator_weights"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("\n  noise of normals: "));
  EXPECT_THAT(dir_.Read("sure.csv"),
              StartsWith("x,y,z,nx,ny,nz,mean_curvature,mean_curvature_standard_error,k1_standard_error,"
                         "k2_standard_error,chosen_neighbor_count,avg_hexagram_weight,normal_regression_weight,"
                         "jet_weight,aso_weight,status"));
  ASSERT_EQ(RunCurv({"estimate", cloud, "-o", out, "--also=standard_errors"}).exit_code, 0);
  EXPECT_THAT(dir_.Read("sure.csv"), StartsWith("x,y,z,nx,ny,nz,mean_curvature,gaussian_curvature,k1,k2,d1x,d1y,d1z,"
                                                "d2x,d2y,d2z,radius,mean_curvature_standard_error,"))
      << "beside what comes by itself";
}

TEST_F(CurvTest, WritesNormalCurvatureInADirection) {
  const std::string cloud = Cloud("sphere", "2000"), out = dir_.File("toward.csv");
  ASSERT_EQ(RunCurv({"estimate", cloud, "-o", out, "--quantities=radius", "--direction=z"}).exit_code, 0);
  const std::string by_axis = dir_.Read("toward.csv");
  EXPECT_THAT(by_axis, StartsWith("x,y,z,nx,ny,nz,radius,normal_curvature,status"));
  ASSERT_EQ(RunCurv({"estimate", cloud, "-o", out, "--quantities=radius", "--direction=0,0,5"}).exit_code, 0);
  EXPECT_EQ(dir_.Read("toward.csv"), by_axis);
  ASSERT_EQ(RunCurv({"estimate", cloud, "-o", out, "--quantities=radius", "--direction-columns=true_d1"}).exit_code, 0);
  EXPECT_NE(dir_.Read("toward.csv"), by_axis);
  EXPECT_THAT(RunCurv({"estimate", cloud, "-o", out, "--direction-columns=fiber"}).err,
              AllOf(HasSubstr("fiberx"), HasSubstr("it has the columns")));
  EXPECT_THAT(RunCurv({"estimate", cloud, "-o", out, "--also=normal_curvature"}).err,
              HasSubstr("needs --direction or --direction-columns"));
  EXPECT_THAT(RunCurv({"estimate", cloud, "-o", out, "--direction=0,0,0"}).err, HasSubstr("not all 0"));
}

TEST_F(CurvTest, SumsUpWhatIsAskedForAndSaysWhichPointsLackIt) {
  const std::string out = dir_.File("r.csv");
  const CurvRun flat = RunCurv(
      {"estimate", Cloud("plane", "200"), "-o", out, "--k=20", "--also=shape_index,curvedness", "--direction=z"});
  ASSERT_EQ(flat.exit_code, 0) << flat.err;
  EXPECT_THAT(flat.out, AllOf(HasSubstr("\n  shape_index  "), ContainsRegex("curvedness +0 +0 +0\n"),
                              ContainsRegex("normal_curvature +nan +nan +nan\n"),
                              HasSubstr("\n  200 ok points without shape_index: k1 and k2 are 0 there\n"),
                              HasSubstr("\n  200 ok points without normal_curvature: the direction is along")));
  const std::string round = Cloud("sphere", "2000");
  EXPECT_THAT(RunCurv({"estimate", round, "-o", out, "--direction-columns=true_d1", "--summary=json"}).out,
              HasSubstr("\"normal_curvature\":{\"least\":"));
  EXPECT_THAT(RunCurv({"estimate", round, "-o", out, "--direction-columns=true_d1"}).out, Not(HasSubstr("without")));
}

}  // namespace
}  // namespace curv
