// curv render as users meet it: what it draws, what it says that it chose, what it refuses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/client/cli/run_curv.h"
#include "tests/client/temp_dir.h"

namespace curv {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

class RenderTest : public ::testing::Test {
 protected:
  RenderTest() : cloud_(dir_.File("torus.ply")) {
    EXPECT_EQ(RunCurv({"generate", "torus", "--points=500", "-o", cloud_}).exit_code, 0);
  }

  CurvRun Render(const std::vector<std::string>& more) const {
    std::vector<std::string> words = {"render", cloud_, "-o", dir_.File("p.png"), "--size=400x300"};
    words.insert(words.end(), more.begin(), more.end());
    return RunCurv(words);
  }
  std::string Picture(const std::vector<std::string>& more) const {
    const CurvRun run = Render(more);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return dir_.Read("p.png");
  }

  const TempDir dir_;
  const std::string cloud_;
};

TEST_F(RenderTest, SaysWhatItChose) {
  EXPECT_THAT(Render({}).out, HasSubstr("mean of " + cloud_ + ", --up=z (as nothing says otherwise) --view=35:25"));
  EXPECT_THAT(Render({"--view=top"}).out, HasSubstr("--up=z (as nothing says otherwise) --view=top"));
  EXPECT_THAT(Render({"--up=y"}).out, AllOf(HasSubstr("--up=y --view="), Not(HasSubstr("("))));
  EXPECT_THAT(Render({"--up=y", "--view=top"}).out, Not(HasSubstr("--")));
  EXPECT_EQ(Picture({}), Picture({"--up=z", "--view=35:25"}));
  EXPECT_NE(Picture({}), Picture({"--up=y"}));
}

TEST_F(RenderTest, DrawsSeveralQuantitiesAndStrokes) {
  const std::string plain = Picture({});
  EXPECT_THAT(plain, StartsWith("\x89PNG"));
  EXPECT_THAT(Render({"--quantity=mean,gaussian,k1,k2"}).out, HasSubstr("p.png: mean, gaussian, k1, k2 of"));
  EXPECT_NE(Picture({"--quantity=mean,k1"}), plain);
  EXPECT_NE(Picture({"--quantity=mean,k1", "--range=-1:1,-2:2"}), Picture({"--quantity=mean,k1", "--range=-1:1"}));
  EXPECT_NE(Picture({"--strokes=d1"}), plain);
  EXPECT_NE(Picture({"--strokes=d1"}), Picture({"--strokes=d1,d2"}));
  EXPECT_NE(Picture({"--title=\u66f2\u7387"}), plain);
}

TEST_F(RenderTest, DrawsNoExactValuesInPlaceOfEstimates) {
  const std::string result = dir_.File("result.ply"), picture = dir_.File("result.png");
  ASSERT_EQ(RunCurv({"estimate", cloud_, "-o", result, "--k=8,16"}).exit_code, 0);
  EXPECT_THAT(RunCurv({"render", result, "-o", picture}).err,
              HasSubstr("there is no column mean_curvature. Name one of mean_curvature_k8, mean_curvature_k16 with"));
  EXPECT_EQ(RunCurv({"render", result, "-o", picture, "--quantity=mean_curvature_k8"}).exit_code, 0);
  ASSERT_EQ(RunCurv({"estimate", cloud_, "-o", result, "--k=16", "--quantities=mean"}).exit_code, 0);
  const CurvRun gaussian = RunCurv({"render", result, "-o", picture, "--quantity=gaussian"});
  EXPECT_EQ(gaussian.exit_code, 3);
  EXPECT_THAT(gaussian.err, AllOf(HasSubstr("no column gaussian_curvature"), HasSubstr("such as true_gaussian")));
  EXPECT_EQ(RunCurv({"render", result, "-o", picture, "--quantity=true_gaussian"}).exit_code, 0);
  EXPECT_THAT(RunCurv({"render", result, "-o", picture, "--strokes=d1"}).err, HasSubstr("no columns d1x d1y d1z"));
}

TEST_F(RenderTest, NotesTextsThatItCannotWrite) {
  // Nobody has letters of the private use area.
  EXPECT_THAT(Render({"--title=H \U0010fff0"}).err, AllOf(HasSubstr("no installed font"), HasSubstr("will be boxes")));
  EXPECT_EQ(Render({"--title=\u05e2\u05e7\u05d5\u05dd \u0627\u0646\u062d\u0646\u0627\u0621"}).err, "");
  EXPECT_EQ(Render({"--title=Kr\u00fcmmung \u0421\u0440", "--unit=\u00b5m"}).err, "");
}

TEST_F(RenderTest, NamesWhatIsWrong) {
  const auto fail = [&](const std::vector<std::string>& more, int exit_code) {
    const CurvRun run = Render(more);
    EXPECT_EQ(run.exit_code, exit_code);
    return run.err;
  };
  EXPECT_THAT(fail({"--quantity=mean,k3"}, 3), HasSubstr("there is no column k3"));
  EXPECT_THAT(fail({"--quantity=mean,k1,k2", "--range=-1:1,-2:2"}, 2),
              HasSubstr("there are 2 ranges for 3 quantities"));
  EXPECT_THAT(fail({"--range=-1:1,-2:2"}, 2), HasSubstr("there are 2 ranges for 1 quantity: "));
  EXPECT_THAT(fail({"--range=-1:1,2:1"}, 2), HasSubstr("\"2:1\" must be LO:HI"));
  EXPECT_THAT(fail({"--strokes=d3"}, 2), HasSubstr("--strokes"));
  EXPECT_THAT(
      RunCurv({"render", cloud_, "-o", dir_.File("p.png"), "--quantity=mean,k1,k2,gaussian", "--size=100x100"}).err,
      HasSubstr("each side must be at least 64"));
  std::string many = "--quantity=x";
  for (int i = 0; i < 16; ++i) many += ",x";
  EXPECT_THAT(fail({many}, 2), HasSubstr("there are 17 quantities: at most 16"));
  const std::string bare = dir_.Write("bare.csv", "x,y,z,nx,ny,nz,mean_curvature\n0,0,0,0,0,1,1\n");
  EXPECT_THAT(RunCurv({"render", bare, "-o", dir_.File("b.png"), "--strokes=d1"}).err,
              HasSubstr("there are no columns d1x d1y d1z for --strokes"));
}

}  // namespace
}  // namespace curv
