// Which estimator runs over which neighborhoods: flags, summaries, columns.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/strings/str_cat.h"
#include "client/io/table_file.h"
#include "tests/client/cli/curv_fixture.h"

namespace curv {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::IsSupersetOf;
using ::testing::Not;

TEST_F(CurvTest, EstimatesWithTheEstimatorThatIsNamed) {
  const std::string cloud = Cloud(), result = dir_.File("result.csv");
  for (const char* estimator :
       {"avg-hexagram", "hexagram", "uniform", "independent", "delaunay", "jet", "aso", "normal-regression"}) {
    const CurvRun run = RunCurv({"estimate", cloud, "-o", result, absl::StrCat("--estimator=", estimator)});
    EXPECT_EQ(run.exit_code, 0) << estimator << ": " << run.err;
    EXPECT_THAT(run.out, HasSubstr(absl::StrCat("points, ", estimator, ", K = 50")));
    EXPECT_THAT(run.err, IsEmpty());
  }
  const CurvRun even =
      RunCurv({"estimate", cloud, "-o", result, "--estimator=delaunay", "--even-weights", "--summary=json"});
  EXPECT_EQ(even.exit_code, 0) << even.err;
  EXPECT_THAT(even.out, HasSubstr("\"even_weights\":true"));
  const CurvRun projected =
      RunCurv({"estimate", cloud, "-o", result, "--estimator=aso", "--project", "--summary=json"});
  EXPECT_EQ(projected.exit_code, 0) << projected.err;
  EXPECT_THAT(projected.out, HasSubstr("\"project\":true"));
  const CurvRun singular = RunCurv({"estimate", cloud, "-o", result, "--estimator=jet", "--jet-degree=4", "--k=14"});
  EXPECT_EQ(singular.exit_code, 0) << singular.err;
  EXPECT_THAT(singular.out, ::testing::ContainsRegex("singular_fit +2,000"));
  EXPECT_THAT(singular.err, HasSubstr("a jet of degree 4 has 15 coefficients"));
}

TEST_F(CurvTest, ChoosesEstimatorAndScale) {
  const std::string cloud = Cloud("sphere", "3000"), out = dir_.File("out.ply");
  const CurvRun run = RunCurv({"estimate", cloud, "-o", out, "--auto"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, IsEmpty());
  EXPECT_THAT(run.out, AllOf(HasSubstr("3,000 points, auto, K = auto"), HasSubstr("\n  chosen by "),
                             HasSubstr("\n  jet, degree 4 "), HasSubstr(" %\n")));
  const std::string by_short = dir_.Read("out.ply");
  ASSERT_EQ(RunCurv({"estimate", cloud, "-o", out, "--estimator=auto", "--k=auto"}).exit_code, 0);
  EXPECT_EQ(dir_.Read("out.ply"), by_short);
  ASSERT_EQ(RunCurv({"estimate", cloud, "-o", out, "--estimator=auto"}).exit_code, 0);
  EXPECT_EQ(dir_.Read("out.ply"), by_short) << "auto leaves K open too";
}

TEST_F(CurvTest, LeavesEstimatorOrScaleAloneOpen) {
  const std::string cloud = Cloud(), out = dir_.File("out.ply");
  const auto summary = [&](std::vector<std::string> flags) {
    flags.insert(flags.begin(), {"estimate", cloud, "-o", out, "--summary=json"});
    const CurvRun run = RunCurv(flags);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.out;
  };
  EXPECT_THAT(summary({"--k=auto", "--estimator=jet"}),
              AllOf(HasSubstr(R"("estimator":"jet","neighbor_count":"auto",)"), HasSubstr("\"jet_degree\":4"),
                    HasSubstr(R"("scale":{"sampled_points":)"), Not(HasSubstr(R"({"estimator":"avg-hexagram")"))));
  const std::string ranged = summary({"--k=auto", "--k-range=64:128", "--per-cloud", "--max-radius=1000"});
  EXPECT_THAT(ranged, AllOf(HasSubstr(R"("neighbor_count":64,)"), HasSubstr(R"("neighbor_count":128,)"),
                            Not(HasSubstr(R"("neighbor_count":45,)")), Not(HasSubstr(R"("neighbor_count":181,)"))));
  const std::string counted = summary({"--estimator=auto", "--k=100"});
  EXPECT_THAT(counted, AllOf(HasSubstr(R"("estimator":"auto","neighbor_count":100,)"), HasSubstr("\"jet_degree\":4"),
                             HasSubstr(R"({"estimator":"jet","degree":4,"neighbor_count":100,)")));
  EXPECT_THAT(summary({"--k=100"}), AllOf(Not(HasSubstr("\"scale\":")), HasSubstr("\"jet_degree\":2")));
  EXPECT_THAT(RunCurv({"estimate", cloud, "-o", out, "--auto", "--max-radius=1e-9"}).err,
              HasSubstr("no point has a result; most are too_few_neighbors: too few points"));
}

TEST_F(CurvTest, FlagsOfScalesThatMakeNoSenseAreRefused) {
  const std::string cloud = Cloud(), out = dir_.File("out.ply");
  const auto message = [&](std::vector<std::string> flags, int exit_code = 2) {
    flags.insert(flags.begin(), {"estimate", cloud, "-o", out});
    const CurvRun run = RunCurv(flags);
    EXPECT_EQ(run.exit_code, exit_code) << run.err;
    EXPECT_FALSE(dir_.Has("out.ply"));
    return run.err;
  };
  EXPECT_THAT(message({"--auto", "--estimator=jet"}), AllOf(HasSubstr("--auto"), HasSubstr("--estimator")));
  EXPECT_THAT(message({"--auto", "--k=50"}), HasSubstr("--auto excludes --k"));
  EXPECT_THAT(message({"--auto", "--radius=1"}), HasSubstr("--auto excludes --radius"));
  EXPECT_THAT(message({"--k=auto", "--radius=1"}), HasSubstr("--radius"));
  EXPECT_THAT(message({"--estimator=auto", "--radius=1"}),
              AllOf(HasSubstr("--estimator=auto"), HasSubstr("--max-radius")));
  EXPECT_THAT(message({"--k=some"}), AllOf(HasSubstr("\"some\""), HasSubstr("auto or a whole number from 4")));
  EXPECT_THAT(message({"--k-range=16:64"}), HasSubstr("--k-range: needs --auto or --k=auto"));
  EXPECT_THAT(message({"--max-radius=1", "--k=50"}), HasSubstr("--max-radius: needs"));
  EXPECT_THAT(message({"--per-cloud", "--estimator=auto", "--k=50"}), HasSubstr("--per-cloud: needs"));
  for (const char* range :
       {"", "64", "64:", ":64", "15:64", "65:64", "16:2049", "16-64", "16:64:128", "-16:64", "16:6.4"}) {
    EXPECT_THAT(message({"--auto", absl::StrCat("--k-range=", range)}), HasSubstr("--k-range")) << range;
  }
  EXPECT_THAT(message({"--auto", "--k-range=65:64"}), HasSubstr("16 <= LEAST <= MOST <= 2048"));
  for (const char* radius : {"0", "-1", "nan", "inf", "wide"}) {
    EXPECT_THAT(message({"--auto", absl::StrCat("--max-radius=", radius)}), HasSubstr("finite number above 0"));
  }
  EXPECT_THAT(message({"--k=auto", "--estimator=hexagram"}),
              HasSubstr("--estimator: hexagram does not go with --k=auto"));
  EXPECT_THAT(message({"--k=auto", "--estimator=jet", "--jet-degree=2"}),
              HasSubstr("--jet-degree: is 2; --k=auto needs --jet-degree=4"));
}

TEST_F(CurvTest, FlagsThatTheEstimatorDoesNotReadAreRefused) {
  const std::string cloud = Cloud(), out = dir_.File("out.ply");
  const std::pair<const char*, const char*> kUnread[] = {
      {"--triangles=7", "jet"},           {"--seed=1", "avg-hexagram"}, {"--rotations=1", "hexagram"},
      {"--jet-degree=3", "avg-hexagram"}, {"--jet-degree=3", "auto"},   {"--regression-degree=2", "jet"},
      {"--even-weights", "uniform"},      {"--project", "avg-hexagram"}};
  for (const auto& [flag, estimator] : kUnread) {
    const CurvRun run = RunCurv({"estimate", cloud, "-o", out, absl::StrCat("--estimator=", estimator), flag});
    EXPECT_EQ(run.exit_code, 2) << flag << run.err;
    EXPECT_THAT(run.err,
                AllOf(HasSubstr("needs --estimator="), HasSubstr(absl::StrCat(estimator, " does not read it"))));
  }
  const CurvRun plan = RunCurv({"tiles", "plan", cloud, "-o", dir_.File("work"), "--triangles=7"});
  EXPECT_EQ(plan.exit_code, 2);
  EXPECT_THAT(plan.err,
              HasSubstr("--triangles: needs --estimator=uniform or independent; avg-hexagram does not read it"));
}

TEST_F(CurvTest, SeveralNeighborCountsAreColumnsForEach) {
  const std::string cloud = Cloud(), scales = dir_.File("scales.ply"), one = dir_.File("one.ply");
  const CurvRun run = RunCurv({"estimate", cloud, "-o", scales, "--k=16,64", "--summary=json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("\"neighbor_counts\":[16,64]"), HasSubstr("{\"neighbor_count\":64,\"status\"")));
  const absl::StatusOr<PointTable> table = LoadTable(scales);
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(ColumnNames(*table),
              IsSupersetOf({"mean_curvature_k16", "d1x_k16", "status_k16", "k2_k64", "status_k64"}));
  EXPECT_THAT(ColumnNames(*table), Not(Contains("mean_curvature")));
  // An earlier estimate is replaced, whatever its scales were, and each scale is what it is alone.
  ASSERT_EQ(RunCurv({"estimate", scales, "-o", one, "--k=64"}).exit_code, 0);
  const absl::StatusOr<PointTable> alone = LoadTable(one);
  ASSERT_TRUE(alone.ok()) << alone.status();
  EXPECT_THAT(ColumnNames(*alone), Not(Contains("status_k16")));
  EXPECT_EQ(alone->Find("mean_curvature")->values, table->Find("mean_curvature_k64")->values);
  const CurvRun text = RunCurv({"estimate", cloud, "-o", scales, "--k=16,64"});
  EXPECT_THAT(text.out, AllOf(HasSubstr("K = 16, 64"), HasSubstr("  K = 64\n"), HasSubstr("mean_curvature_k64")));
  EXPECT_EQ(RunCurv({"render", scales, "-o", dir_.File("k.png"), "--quantity=mean_curvature_k64"}).exit_code, 0);
}

TEST_F(CurvTest, ColorsOfSeveralNeighborCountsAreThoseOfTheLargest) {
  const std::string cloud = Cloud(), scales = dir_.File("scales.ply"), one = dir_.File("one.ply");
  ASSERT_EQ(RunCurv({"estimate", cloud, "-o", scales, "--k=16,64", "--color=gaussian"}).exit_code, 0);
  ASSERT_EQ(RunCurv({"estimate", cloud, "-o", one, "--k=64", "--color=gaussian"}).exit_code, 0);
  const absl::StatusOr<PointTable> of_scales = LoadTable(scales), of_one = LoadTable(one);
  ASSERT_TRUE(of_scales.ok() && of_one.ok());
  for (const char* name : {"red", "green", "blue"}) {
    ASSERT_NE(of_scales->Find(name), nullptr) << name;
    EXPECT_EQ(of_scales->Find(name)->values, of_one->Find(name)->values) << name;
  }
}

TEST_F(CurvTest, EvaluatesEachOfSeveralNeighborCounts) {
  const std::string cloud = Cloud(), scales = dir_.File("scales.ply"), one = dir_.File("one.ply");
  ASSERT_EQ(RunCurv({"estimate", cloud, "-o", scales, "--k=16,64"}).exit_code, 0);
  ASSERT_EQ(RunCurv({"estimate", cloud, "-o", one, "--k=64"}).exit_code, 0);
  const CurvRun text = RunCurv({"evaluate", scales});
  ASSERT_EQ(text.exit_code, 0) << text.err;
  EXPECT_THAT(text.out, AllOf(HasSubstr("scales.ply, K = 16: "), HasSubstr("scales.ply, K = 64: ")));
  // What is said of one number of neighbors is what is said of it alone.
  const std::string alone = RunCurv({"evaluate", one}).out;
  EXPECT_THAT(text.out, HasSubstr(alone.substr(alone.find(": "))));
  EXPECT_THAT(
      RunCurv({"evaluate", scales, "--json"}).out,
      AllOf(HasSubstr("\"scales\":[{\"neighbor_count\":16,\"compared\":"), HasSubstr("{\"neighbor_count\":64,")));
}

TEST_F(CurvTest, EvaluatesNoNumberOfNeighborsThatCannotBe) {
  const std::string cloud =
      dir_.Write("strange.csv", "x,y,z,mean_curvature_k99999999999999999999999,true_mean\n0,0,0,1,1\n1,0,0,1,1\n");
  for (const CurvRun& run : {RunCurv({"evaluate", cloud}), RunCurv({"evaluate", cloud, "--json"})}) {
    EXPECT_EQ(run.exit_code, 3);
    EXPECT_THAT(run.err, HasSubstr("strange.csv: there are no estimates"));
  }
}

TEST_F(CurvTest, RefusesNeighborCountsThatMakeNoSense) {
  const std::string cloud = Cloud(), out = dir_.File("out.ply");
  for (const char* k : {"--k=64,16", "--k=16,16", "--k=3,16", "--k=16,", "--k=16,auto"}) {
    const CurvRun run = RunCurv({"estimate", cloud, "-o", out, k});
    EXPECT_EQ(run.exit_code, 2) << k;
    EXPECT_THAT(run.err, HasSubstr("that ascend, with commas between")) << k;
  }
  EXPECT_THAT(
      RunCurv({"estimate", cloud, "-o", out, "--k=16,64", "--estimator=jet"}).err,
      HasSubstr("--k: is a list, which needs --estimator=avg-hexagram or normal-regression; jet takes one number"));
}

}  // namespace
}  // namespace curv
