// curv report as users meet it: exit codes, messages, files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "tests/client/cli/run_curv.h"
#include "tests/client/temp_dir.h"

namespace curv {
namespace {

using ::testing::HasSubstr;

class ReportCommandTest : public ::testing::Test {
 protected:
  ReportCommandTest()
      : cloud_(dir_.Write("cloud.csv", "x,y,z,k1,red,status\n0,0,0,1,9,ok\n1,0,0,nan,9,singular_fit\n1,2,0,3,9,ok\n")) {
  }

  const TempDir dir_;
  const std::string cloud_;
};

TEST_F(ReportCommandTest, WritesOneFileAndSaysHowLarge) {
  const CurvRun run = RunCurv({"report", cloud_, "-o", dir_.File("r.html"), "--points=2", "--unit=mm", "--up=y"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("r.html: 2 of 3 points of"));
  std::stringstream page;
  page << std::ifstream(dir_.File("r.html")).rdbuf();
  EXPECT_THAT(page.str(), HasSubstr("\"unit\":\"mm\",\"up\":\"y\""));
  EXPECT_THAT(page.str(), HasSubstr("{\"value\":6,\"word\":\"singular_fit\",\"count\":1}"));
}

TEST_F(ReportCommandTest, NamesWhatIsWrong) {
  const auto fail = [&](std::vector<std::string> more, int exit_code) {
    std::vector<std::string> words = {"report", cloud_};
    words.insert(words.end(), more.begin(), more.end());
    const CurvRun run = RunCurv(words);
    EXPECT_EQ(run.exit_code, exit_code);
    return run.err;
  };
  const std::string page = dir_.File("r.html");
  EXPECT_THAT(fail({"-o", dir_.File("r.htm")}, 4), HasSubstr("reports are written as .html"));
  EXPECT_THAT(fail({"-o", dir_.File("no/r.html")}, 4), HasSubstr("no/r.html"));
  EXPECT_THAT(fail({"-o", page, "--quantity=density"}, 3), HasSubstr("there is no quantity density"));
  EXPECT_THAT(fail({"-o", page, "--quantity=red"}, 3), HasSubstr("there is no quantity red"));
  EXPECT_THAT(fail({"-o", page, "--points=0"}, 2), HasSubstr("--points"));
  EXPECT_THAT(fail({"-o", page, "--up=x"}, 2), HasSubstr("--up"));
  EXPECT_EQ(RunCurv({"report", dir_.Write("flat.csv", "x,y\n1,2\n"), "-o", page}).exit_code, 3);
  EXPECT_EQ(RunCurv({"report", dir_.File("none.ply"), "-o", page}).exit_code, 3);
  EXPECT_FALSE(dir_.Has("r.html"));
}

TEST_F(ReportCommandTest, ViewRefusesWhatItCannotShow) {
  const CurvRun none = RunCurv({"view", dir_.File("none.ply")});
  EXPECT_EQ(none.exit_code, 3);
  EXPECT_THAT(none.err, HasSubstr("none.ply"));
  EXPECT_EQ(none.out, "");
  EXPECT_EQ(RunCurv({"view", dir_.Write("nowhere.csv", "x,y,z\nnan,1,2\n")}).exit_code, 3);
  EXPECT_THAT(RunCurv({"view", "-", "--watch"}).err, HasSubstr("--watch needs a file"));
}

TEST_F(ReportCommandTest, ReadsWhatHasNoNameThatTellsItsFormat) {
  const CurvRun nameless = RunCurv({"report", "-", "-o", dir_.File("r.html")}, cloud_);
  EXPECT_THAT(nameless.err, HasSubstr("say --format=ply"));
  const CurvRun run = RunCurv({"report", "-", "--format=csv", "-o", dir_.File("r.html")}, cloud_);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("3 of 3 points of standard input"));
  std::stringstream page;
  page << std::ifstream(dir_.File("r.html")).rdbuf();
  EXPECT_THAT(page.str(), HasSubstr("standard input"));
  EXPECT_THAT(RunCurv({"view", "-", "--format=csv"}, dir_.Write("flat", "x,y\n1,2\n")).err,
              HasSubstr("standard input: the file has no"));
}

TEST_F(ReportCommandTest, ShowsWhatIsAskedFor) {
  for (const std::string quantity : {"k1", "status"}) {
    EXPECT_EQ(RunCurv({"report", cloud_, "-o", dir_.File("r.html"), "--quantity=" + quantity}).exit_code, 0);
  }
}

}  // namespace
}  // namespace curv
