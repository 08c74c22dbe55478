#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "tests/client/cli/curv_fixture.h"
#include "tests/client/local_server.h"

namespace curv {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

// Neither the input nor the server is there: flags are judged before either is asked.
CurvRun RunOnNothing(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin() + 1, {"nowhere.ply", "-o", "out.ply", "--server=localhost:1"});
  return RunCurv(arguments);
}

TEST(OptionConflictsTest, AreFoundBeforeAnythingIsRead) {
  const struct {
    std::vector<std::string> arguments;
    std::string message;
  } kConflicts[] = {
      {{"estimate", "--also=standard_errors", "--estimator=uniform"},
       "--estimator: uniform does not go with standard_errors, which needs auto, "},
      {{"estimate", "--also=standard_errors", "--k=15"}, "--k: is 15; it must be from 16 to 2048"},
      {{"estimate", "--also=standard_errors", "--k=2049"}, "--k: is 2049; it must be from 16 to 2048"},
      {{"estimate", "--quantities=standard_errors", "--k=16,64"}, "--k: is a list; standard_errors needs one"},
      {{"estimate", "--also=standard_errors", "--radius=1"}, "--radius: does not go with standard_errors"},
      {{"estimate", "--also=standard_errors", "--estimator=jet"},
       "--jet-degree: is 2; standard_errors needs --jet-degree=4"},
      {{"estimate", "--also=standard_errors", "--estimator=aso"},
       "--also: standard_errors needs --project with --estimator=aso"},
      {{"estimate", "--k=auto", "--estimator=delaunay"}, "--estimator: delaunay does not go with --k=auto"},
      {{"estimate", "--k=auto", "--estimator=jet", "--jet-degree=3"}, "--jet-degree: is 3; --k=auto needs"},
      {{"estimate", "--k=15", "--estimator=auto"}, "--k: is 15; it must be from 16 to 2048 with --estimator=auto"},
      {{"estimate", "--k=16,64", "--estimator=aso"}, "--k: is a list, which needs --estimator=avg-hexagram or"},
      {{"estimate", "--k=16,64", "--quantities=normals"}, "--k: needs a quantity of curvature among --quantities"},
      {{"estimate", "--auto", "--quantities=normals"}, "--auto: needs a quantity of curvature"},
      {{"estimate", "--estimator=aso", "--quantities=normals,normal_quality"}, "--estimator: needs a quantity"},
      {{"estimate", "--average-normal-weight=0.2", "--quantities=normals"},
       "--average-normal-weight: needs a quantity"},
      {{"estimate", "--rotations=3", "--quantities=normals"}, "--rotations: needs a quantity of curvature"},
      {{"estimate", "--tiles", "--also=standard_errors,shape_index"},
       "--also: tiles have no standard_errors: errors and choices follow from a sample of the whole cloud\n"},
      {{"estimate", "--force"}, "--force: needs a directory for --output, as results/"},
      {{"estimate", "--force", "--tiles"}, "--force: needs a directory for --output, as results/"},
      {{"estimate", "--also=chosen_neighbor_count"}, "--also: chosen_neighbor_count needs --auto or --k=auto"},
      {{"estimate", "--quantities=estimator_weights", "--k=64"},
       "--quantities: estimator_weights needs --auto or --k=auto"},
      {{"estimate", "--on-opposed-normals=reject", "--quantities=normal_quality"},
       "--on-opposed-normals: reject needs a quantity of curvature among --quantities"},
      {{"estimate", "--normals=estimate", "--normal-k=14", "--normal-method=jet-4"},
       "--normal-k: is 14; with --normal-method=jet-4 it must be at least 15"},
      {{"normals", "--k=5"}, "--k: is 5; with --method=jet-2, the default, it must be at least 6"},
  };
  for (const auto& [arguments, message] : kConflicts) {
    const CurvRun run = RunOnNothing(arguments);
    EXPECT_EQ(run.exit_code, 2) << message << run.err;
    EXPECT_THAT(run.err, StartsWith("curv: " + message));
    EXPECT_THAT(run.err, Not(HasSubstr("header.")));
  }
}

TEST(SwitchesTest, TakeNoOtherValueThanYesOrNo) {
  for (const char* flag : {"--tiles=20000", "--auto=maybe", "--ascii=99999999999999999999", "--tls=-1"}) {
    const CurvRun run = RunOnNothing({"estimate", flag});
    EXPECT_EQ(run.exit_code, 2) << flag;
    EXPECT_THAT(run.err, HasSubstr("\" must be true or false")) << flag;
  }
  EXPECT_EQ(RunOnNothing({"normals", "--up=sideways"}).exit_code, 2);
  for (const char* flag : {"--tiles=false", "--ascii=No", "--closed=TRUE", "--consistent", "--up", "--up=-z"}) {
    EXPECT_EQ(RunOnNothing({flag[2] == 't' ? "estimate" : "normals", flag}).exit_code, 3) << flag;  // no such input
  }
}

TEST(OptionConflictsTest, WhatGoesTogetherIsNotRefused) {
  const std::vector<std::string> kFine[] = {
      {"estimate", "--also=standard_errors", "--estimator=aso", "--project", "--k=2048"},
      {"estimate", "--also=standard_errors", "--estimator=aso", "--k=auto"},
      {"estimate", "--also=standard_errors", "--estimator=jet", "--jet-degree=4", "--k=16"},
      {"estimate", "--also=estimator_weights", "--estimator=jet", "--k=auto"},
      {"estimate", "--also=chosen_neighbor_count", "--estimator=auto", "--k=16"},
      {"estimate", "--k=16,64", "--estimator=normal-regression", "--quantities=mean,normals"},
      {"estimate", "--normals=estimate", "--normal-method=pca", "--normal-k=4"},
      {"normals", "--method=jet-4", "--k=15"},
  };
  for (const std::vector<std::string>& arguments : kFine) {
    EXPECT_EQ(RunOnNothing(arguments).exit_code, 3) << arguments.back();
  }
}

TEST_F(CurvTest, WhatOnlyTheServerKnowsIsSaidOnceInFlags) {
  curvd::ServerOptions limits;
  limits.max_neighbor_count = 64;
  const auto server = StartServer(limits);
  const std::string cloud = Cloud("sphere", "100"), out = dir_.File("out.ply");
  const std::string at = absl::StrCat("--server=127.0.0.1:", server->port());
  const CurvRun estimate = RunCurv({"estimate", cloud, "-o", out, at, "--k=100"});
  EXPECT_EQ(estimate.exit_code, 1);
  EXPECT_THAT(estimate.err, ContainsRegex(": --k is 100; it must be at most 64 \\(max_neighbor_count\\) \\(request "
                                          "[^ ]*\\) \\[reason NEIGHBORHOOD_TOO_LARGE\\]\n$"));
  EXPECT_THAT(RunCurv({"estimate", cloud, "-o", out, at, "--normals=estimate", "--normal-k=100", "--k=9"}).err,
              HasSubstr(": --normal-k is 100; it must be at most 64"));
  EXPECT_THAT(RunCurv({"normals", cloud, "-o", out, at, "--k=100"}).err, HasSubstr(": --k is 100; it must be at most"));
  EXPECT_THAT(RunCurv({"estimate", cloud, "-o", out, at, "--normals=estimate", "--normal-radius=9", "--k=9"}).err,
              HasSubstr("; use a smaller --normal-radius, or --normal-k ("));
  for (const char* command : {"estimate", "normals"}) {
    EXPECT_THAT(RunCurv({command, cloud, "-o", out, at, "--radius=9"}).err,
                HasSubstr("; use a smaller --radius, or --k ("));
  }
}

}  // namespace
}  // namespace curv
