// The program as users meet it: exit codes, messages, files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "absl/strings/str_cat.h"
#include "client/io/table_file.h"
#include "server/curvature_server.h"
#include "tests/client/cli/curv_fixture.h"

namespace curv {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;

TEST_F(CurvTest, HelpTeachesAndSucceeds) {
  for (const auto& words : std::vector<std::vector<std::string>>{{"--help"},
                                                                 {"estimate", "--help"},
                                                                 {"generate", "-h"},
                                                                 {"normals", "-h"},
                                                                 {"orient", "-h"},
                                                                 {"evaluate", "-h"},
                                                                 {"render", "-h"},
                                                                 {"select", "-h"},
                                                                 {"report", "-h"},
                                                                 {"view", "-h"},
                                                                 {"info", "-h"}}) {
    const CurvRun run = RunCurv(words);
    EXPECT_EQ(run.exit_code, 0);
    EXPECT_THAT(run.out, AllOf(HasSubstr("Usage"), HasSubstr("Exit codes")));
  }
  EXPECT_THAT(RunCurv({"--version"}).out, StartsWith("curv 0."));
}

TEST_F(CurvTest, WrongFlagsNameFlagValueAndLimit) {
  const std::string cloud = Cloud(), out = dir_.File("out.ply");
  const auto message = [](std::vector<std::string> words) {
    const CurvRun run = RunCurv(words);
    EXPECT_EQ(run.exit_code, 2) << absl::StrCat(words[0], ": ", run.err);
    EXPECT_THAT(run.out, IsEmpty());
    return run.err;
  };
  EXPECT_THAT(message({"estimate", cloud, "-o", out, "--k=3"}),
              AllOf(HasSubstr("--k"), HasSubstr("\"3\""), HasSubstr("4 to 1000000")));
  EXPECT_THAT(message({"estimate", cloud, "-o", out, "--radius=-1"}),
              AllOf(HasSubstr("--radius"), HasSubstr("\"-1\"")));
  EXPECT_THAT(message({"estimate", cloud, "-o", out, "--radius=nan"}), HasSubstr("finite number above 0"));
  EXPECT_THAT(message({"estimate", cloud, "-o", out, "--radius=1", "--k=50"}), HasSubstr("--k"));
  EXPECT_THAT(message({"estimate", cloud, "-o", out, "--triangles=10001"}), HasSubstr("1 to 10000"));
  EXPECT_THAT(message({"estimate", cloud, "-o", out, "--estimator=best"}),
              AllOf(HasSubstr("best"), HasSubstr("independent"), HasSubstr("jet")));
  EXPECT_THAT(message({"estimate", cloud, "-o", out, "--quantities=mean,curl"}),
              AllOf(HasSubstr("--quantities"), HasSubstr("curl"), HasSubstr("principal_curvatures")));
  EXPECT_THAT(message({"estimate", cloud, "-o", out, "--quantities=k1", "--color=mean"}), HasSubstr("--color"));
  EXPECT_THAT(message({"estimate", cloud, "-o", out, "--jet-degree=5"}),
              AllOf(HasSubstr("--jet-degree"), HasSubstr("\"5\""), HasSubstr("2 to 4")));
  EXPECT_THAT(message({"estimate", cloud, "-o", out, "--seed=-1"}), AllOf(HasSubstr("--seed"), HasSubstr("\"-1\"")));
  EXPECT_THAT(message({"estimate", cloud, "-o", out, "--server="}), HasSubstr("--server"));
  EXPECT_THAT(message({"estimate", cloud, "-o", out, "--server=nowhere:"}),
              HasSubstr("\"nowhere:\" is neither HOST nor HOST:PORT"));
  // Before the input is read.
  EXPECT_THAT(message({"estimate", "absent.ply", "-o", out, "--server=,"}), HasSubstr("is neither HOST nor HOST:PORT"));
  EXPECT_THAT(message({"info", "--server=https://a"}),
              AllOf(HasSubstr("--server: "), HasSubstr("without https://: TLS has an option of its own")));
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {"estimate", cloud, "-o", out}, {"normals", cloud, "-o", out}, {"tiles", "run", dir_.File("work")}}) {
    std::vector<std::string> both = words;
    both.insert(both.end(), {"--threads=2", "--server=localhost:1"});
    EXPECT_THAT(message(both), HasSubstr("--server excludes --threads"));
  }
  EXPECT_THAT(message({"estimate", cloud, "-o", out, "--color=pink"}), HasSubstr("pink"));
  EXPECT_THAT(message({"estimate", cloud}), HasSubstr("--output"));
  EXPECT_THAT(message({"generate", "klein", "--points=10", "-o", out}), AllOf(HasSubstr("klein"), HasSubstr("torus")));
  EXPECT_THAT(message({"generate", "torus", "--points=0", "-o", out}), HasSubstr("1 to 100000000"));
  EXPECT_THAT(message({"generate", "torus", "--points=0100", "-o", out}), HasSubstr("without zeros before it"));
  for (const char* noise : {"--noise-position=1e300", "--noise-normal=1e38", "--noise-position=-1"}) {
    EXPECT_THAT(message({"generate", "torus", "--points=10", "-o", out, noise}), HasSubstr("from 0 to 1e+37")) << noise;
  }
  EXPECT_THAT(message({"render", cloud, "-o", "x.png", "--range=2:1"}), HasSubstr("LO < HI"));
  EXPECT_THAT(message({"render", cloud, "-o", "x.png", "--size=10x10"}), HasSubstr("from 64 to 4096"));
  EXPECT_THAT(message({"render", cloud, "-o", "x.png", "--view=inside"}), HasSubstr("\"inside\""));
  EXPECT_THAT(message({"paint"}), HasSubstr("paint"));
  EXPECT_FALSE(dir_.Has("out.ply"));
}

TEST_F(CurvTest, EstimatesEvaluatesAndRenders) {
  const std::string result = dir_.File("result.ply");
  const CurvRun estimate = RunCurv({"estimate", Cloud(), "-o", result, "--color"});
  ASSERT_EQ(estimate.exit_code, 0) << estimate.err;
  EXPECT_THAT(estimate.err, IsEmpty());
  EXPECT_THAT(estimate.out, AllOf(HasSubstr("2,000 points"), HasSubstr("ok"), HasSubstr("seconds:")));
  const PointTable table = *LoadTable(result);
  EXPECT_THAT(ColumnNames(table),
              ::testing::ElementsAre("x", "y", "z", "nx", "ny", "nz", "mean_curvature", "gaussian_curvature", "k1",
                                     "k2", "d1x", "d1y", "d1z", "d2x", "d2y", "d2z", "radius", "status", "true_mean",
                                     "true_gaussian", "true_k1", "true_k2", "true_d1x", "true_d1y", "true_d1z",
                                     "true_d2x", "true_d2y", "true_d2z", "red", "green", "blue"));

  const CurvRun evaluate = RunCurv({"evaluate", result});
  EXPECT_EQ(evaluate.exit_code, 0) << evaluate.err;
  EXPECT_THAT(evaluate.out, AllOf(HasSubstr("2,000 of 2,000"), HasSubstr("gaussian"), HasSubstr("degrees")));
  EXPECT_THAT(RunCurv({"evaluate", result, "--json"}).out, StartsWith("{\"input\":"));

  const CurvRun render = RunCurv({"render", result, "-o", dir_.File("p.png"), "--quantity=k2", "--size=200x150"});
  EXPECT_EQ(render.exit_code, 0) << render.err;
  EXPECT_THAT(dir_.Read("p.png"), StartsWith("\x89PNG"));
}

TEST_F(CurvTest, CsvHasTheDocumentedHeaderAndWords) {
  const CurvRun run =
      RunCurv({"estimate", dir_.Write("two.xyz", "0 0 0 0 0 1\n1 0 0 0 0 1\n"), "-o", dir_.File("r.csv")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(
      dir_.Read("r.csv"),
      StartsWith("x,y,z,nx,ny,nz,mean_curvature,gaussian_curvature,k1,k2,d1x,d1y,d1z,d2x,d2y,d2z,radius,status\n"
                 "0,0,0,0,0,1,nan,nan,nan,nan,nan,nan,nan,nan,nan,nan,nan,too_few_neighbors\n"));
  EXPECT_THAT(run.out, HasSubstr("too_few_neighbors"));
}

TEST_F(CurvTest, EmbeddedAndRemoteGiveTheSameBytes) {
  curvd::ServerOptions options;
  options.listen = "127.0.0.1:0";
  options.metrics_listen = "";
  options.log = false;
  const auto server = *curvd::CurvatureServer::Create(options);
  const std::string cloud = Cloud();
  const std::string remote = absl::StrCat("--server=127.0.0.1:", server->port());
  ASSERT_EQ(RunCurv({"estimate", cloud, "-o", dir_.File("a.ply")}).exit_code, 0);
  ASSERT_EQ(RunCurv({"estimate", cloud, "-o", dir_.File("b.ply"), remote}).exit_code, 0);
  EXPECT_EQ(dir_.Read("a.ply"), dir_.Read("b.ply"));
  const CurvRun info = RunCurv({"info", remote});
  EXPECT_EQ(info.exit_code, 0) << info.err;
  EXPECT_THAT(info.out, AllOf(HasSubstr("SERVING"), HasSubstr("avg-hexagram"), HasSubstr("at most")));
  EXPECT_THAT(RunCurv({"info", remote, "--json"}).out, HasSubstr("\"limits\":{\"max_points\":"));
}

TEST_F(CurvTest, JsonSummaryIsOneLine) {
  const CurvRun run = RunCurv({"estimate", Cloud(), "-o", dir_.File("r.ply"), "--summary=json", "--radius=0.9"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, AllOf(StartsWith("{\"input\":"), HasSubstr("\"points\":2000"), HasSubstr("\"radius\":0.9"),
                             HasSubstr("\"seconds\":{\"read\":")));
  EXPECT_EQ(run.out.find('\n'), run.out.size() - 1);
}

TEST_F(CurvTest, BadInputSaysWhatToDo) {
  const std::string out = dir_.File("out.ply");
  const auto message = [&](const std::string& input) {
    const CurvRun run = RunCurv({"estimate", input, "-o", out});
    EXPECT_EQ(run.exit_code, 3) << input;
    EXPECT_FALSE(dir_.Has("out.ply"));
    return run.err;
  };
  EXPECT_THAT(message(dir_.File("missing.ply")), HasSubstr("missing.ply: No such file"));
  EXPECT_THAT(message(dir_.Write("bare.xyz", "1 2 3\n")),
              AllOf(HasSubstr("bare.xyz: the file has no normals"), HasSubstr("--normals=estimate")));
  EXPECT_THAT(message(dir_.Write("bad.xyz", "1 2 3 0 0 1\n1 2\n")), HasSubstr("bad.xyz: line 2"));
  EXPECT_THAT(message(dir_.Write("cloud.e57", "")), HasSubstr(".e57"));
  EXPECT_THAT(message(dir_.Write("empty.xyz", "")), HasSubstr("empty.xyz: the file holds no points, it is empty"));
  EXPECT_THAT(message(dir_.Write("names.csv", "x,y,z,nx,ny,nz\n")), HasSubstr("names.csv: the file holds no points"));
  EXPECT_EQ(RunCurv({"evaluate", Cloud()}).exit_code, 3);
  EXPECT_THAT(RunCurv({"evaluate", dir_.Write("n.csv", "x\n1\n")}).err, HasSubstr("true_mean"));
  EXPECT_THAT(
      RunCurv({"render", Cloud(), "-o", dir_.File("p.png"), "--quantity=density"}).err,
      HasSubstr("no column density: --quantity must be one of mean, gaussian, k1, k2, or the name of a column"));
}

TEST_F(CurvTest, PicturesNeedAFont) {
  const std::string cloud = Cloud();
  const std::string fonts = dir_.Write("none.conf", "<?xml version=\"1.0\"?><fontconfig></fontconfig>");
  setenv("FONTCONFIG_FILE", fonts.c_str(), 1);
  const CurvRun large = RunCurv({"render", cloud, "-o", dir_.File("large.png")});
  const CurvRun small = RunCurv({"render", cloud, "-o", dir_.File("small.png"), "--size=64x64"});
  unsetenv("FONTCONFIG_FILE");
  EXPECT_EQ(large.exit_code, 4);
  EXPECT_THAT(large.err, AllOf(HasSubstr("no font is installed"), HasSubstr("fonts-dejavu-core")));
  EXPECT_FALSE(dir_.Has("large.png"));
  EXPECT_EQ(small.exit_code, 0) << small.err;
}

TEST_F(CurvTest, BadOutputFailsBeforeTheWorkAndChangesNothing) {
  const std::string cloud = Cloud();
  EXPECT_EQ(RunCurv({"estimate", cloud, "-o", dir_.File("missing/out.ply")}).exit_code, 4);
  EXPECT_EQ(RunCurv({"estimate", cloud, "-o", dir_.File("out.doc")}).exit_code, 4);
  EXPECT_EQ(RunCurv({"render", cloud, "-o", dir_.File("out.jpg")}).exit_code, 4);
  std::filesystem::create_symlink("/dev/full", dir_.File("full.ply"));
  const CurvRun full = RunCurv({"estimate", cloud, "-o", dir_.File("full.ply")});
  EXPECT_EQ(full.exit_code, 4);
  EXPECT_THAT(full.err, HasSubstr("No space left on device"));
  EXPECT_EQ(dir_.FileCount(), 2u);  // the cloud and the link
}

TEST_F(CurvTest, UnreachableServersAndTimeoutsHaveTheirCodes) {
  const std::string cloud = Cloud();
  const CurvRun run =
      RunCurv({"estimate", cloud, "-o", dir_.File("out.ply"), "--server=127.0.0.1:1", "--max-attempts=1"});
  EXPECT_EQ(run.exit_code, 5) << run.err;
  EXPECT_THAT(run.err, AllOf(HasSubstr("UNAVAILABLE"), HasSubstr("curv doctor, with the same --server")));
  const CurvRun info = RunCurv({"info", "--server=127.0.0.1:1"});
  EXPECT_EQ(info.exit_code, 5) << info.err;
  EXPECT_THAT(info.err, HasSubstr("curv doctor, with the same --server"));
  // A call to a server on the same machine may end within the millisecond to which deadlines are kept: this takes many.
  const std::string large = dir_.File("large.ply");
  ASSERT_EQ(RunCurv({"generate", "torus", "--points=100000", "-o", large}).exit_code, 0);
  const CurvRun late = RunCurv({"estimate", large, "-o", dir_.File("out.ply"), "--k=1000", "--timeout=0.000001"});
  EXPECT_EQ(late.exit_code, 6) << late.err;
  EXPECT_THAT(late.err, HasSubstr("the call took longer than --timeout allows"));
  EXPECT_FALSE(dir_.Has("out.ply"));
}

TEST_F(CurvTest, GenerateIsReproducibleAndNoisyOnRequest) {
  const auto generate = [&](const std::string& name, std::vector<std::string> flags) {
    std::vector<std::string> words = {"generate", "goursat", "--points=500", "-o", dir_.File(name)};
    words.insert(words.end(), flags.begin(), flags.end());
    EXPECT_EQ(RunCurv(words).exit_code, 0);
    return dir_.Read(name);
  };
  const std::string clean = generate("a.ply", {});
  EXPECT_EQ(clean, generate("b.ply", {}));
  EXPECT_NE(clean, generate("c.ply", {"--seed=1"}));
  EXPECT_NE(clean, generate("d.ply", {"--noise-position=0.1", "--noise-normal=0.1", "--double"}));
  const PointTable noisy = *LoadTable(dir_.File("d.ply")), exact = *LoadTable(dir_.File("a.ply"));
  EXPECT_EQ(noisy.Find("x")->kind(), ScalarKind::kFloat64);
  for (size_t i = 0; i < 500; ++i) {
    EXPECT_FLOAT_EQ(static_cast<float>(noisy.Find("true_k1")->At(i)), static_cast<float>(exact.Find("true_k1")->At(i)));
    EXPECT_LT(std::abs(noisy.Find("x")->At(i) - exact.Find("x")->At(i)), 0.6);  // six sigma
  }
}

TEST_F(CurvTest, NamesAMistypedFlagBeforeWhatIsMissingForIt) {
  const CurvRun mistyped = RunCurv({"estimate", Cloud(), "--outptu=" + dir_.File("r.ply")});
  EXPECT_EQ(mistyped.exit_code, 2);
  EXPECT_THAT(mistyped.err, AllOf(HasSubstr("not expected: --outptu="), HasSubstr("did you mean --output?"),
                                  HasSubstr("Run curv estimate --help"), Not(HasSubstr("required"))));
  EXPECT_THAT(RunCurv({"estimate", Cloud()}).err, HasSubstr("--output is required"));
  EXPECT_THAT(RunCurv({"estimate", "--", Cloud()}).err, HasSubstr("--output is required"));
  const CurvRun very_long = RunCurv({"estimate", Cloud(), "--" + std::string(300, 'x')});
  EXPECT_EQ(very_long.exit_code, 2);
  EXPECT_THAT(very_long.err, HasSubstr("not expected: --xxx"));
  EXPECT_THAT(RunCurv({"info", Cloud()}).err, Not(HasSubstr("./")));
}

TEST_F(CurvTest, NamesTheNearestCommand) {
  const CurvRun mistyped = RunCurv({"estmate", "x"});
  EXPECT_EQ(mistyped.exit_code, 2);
  EXPECT_EQ(mistyped.err,
            "curv: there is no command estmate; did you mean estimate?\nRun curv --help for what is possible.\n");
  EXPECT_THAT(
      RunCurv({"tiles", "sttus", "x"}).err,
      AllOf(HasSubstr("no command sttus of curv tiles; did you mean status?"), HasSubstr("Run curv tiles --help")));
  EXPECT_THAT(RunCurv({"paint"}).err, AllOf(HasSubstr("no command paint\n"), Not(HasSubstr("did you mean"))));
  EXPECT_THAT(RunCurv({"info", "first", "second"}).err, HasSubstr("not expected: first second"));
}

TEST_F(CurvTest, SaysWhichValueIsMissingAndWhichSizesThereAre) {
  EXPECT_THAT(RunCurv({"estimate", Cloud(), "-o", dir_.File("r.ply"), "--k="}).err,
              HasSubstr("--k: its value is missing or empty: points in a neighborhood, itself included; several, as "));
  for (const char* size : {"512", "lots", "1.5MiB", "-1GiB", ""}) {
    const CurvRun run = RunCurv({"tiles", "plan", Cloud(), "-o", dir_.File("work"), absl::StrCat("--memory=", size)});
    EXPECT_EQ(run.exit_code, 2) << size;
    EXPECT_THAT(run.err,
                HasSubstr(*size == 0 ? "--memory: its value is missing"
                                     : absl::StrCat("--memory: \"", size, "\" must be a size of 16MiB or more")));
  }
  EXPECT_EQ(RunCurv({"tiles", "plan", Cloud(), "-o", dir_.File("work"), "--memory=16MiB"}).exit_code, 0);
}

TEST_F(CurvTest, RefusesFlagsOfAServerWithoutOne) {
  const std::string cloud = Cloud(), out = dir_.File("r.ply");
  for (const char* flag : {"--tls", "--ca=none", "--key=none", "--token-file=none", "--server-name=a"}) {
    const CurvRun run = RunCurv({"estimate", cloud, "-o", out, flag});
    EXPECT_EQ(run.exit_code, 2) << flag;
    EXPECT_THAT(run.err, HasSubstr(": needs --server")) << flag;
    EXPECT_THAT(RunCurv({"normals", "none.ply", "-o", out, flag}).err, HasSubstr(": needs --server")) << flag;
    EXPECT_FALSE(dir_.Has("r.ply")) << flag;
  }
}

TEST_F(CurvTest, CountsOnePoint) {
  const std::string cloud = dir_.File("one.ply"), result = dir_.File("r.ply");
  EXPECT_THAT(RunCurv({"generate", "torus", "--points=1", "-o", cloud}).out, HasSubstr(": 1 point of the surface"));
  const CurvRun normals = RunCurv({"normals", cloud, "-o", dir_.File("n.ply")});
  EXPECT_THAT(normals.out, HasSubstr(": 1 point, normals by pca of 1 point; 1 point has none"));
  EXPECT_THAT(normals.err, AllOf(HasSubstr("needs 4 points or more, and the cloud has 1: send more points"),
                                 Not(HasSubstr("radius"))));
  EXPECT_THAT(RunCurv({"orient", cloud, "-o", dir_.File("o.ply")}).out, HasSubstr("negated 0 of 1 normal\n"));
  EXPECT_THAT(RunCurv({"select", cloud, "-o", dir_.File("s.ply"), "--where=x > -99"}).out,
              HasSubstr(": 1 of 1 point\n"));
  EXPECT_EQ(RunCurv({"estimate", cloud, "-o", result}).exit_code, 0);
  const CurvRun evaluated = RunCurv({"evaluate", result});
  EXPECT_EQ(evaluated.exit_code, 0);
  EXPECT_THAT(evaluated.out, AllOf(HasSubstr(": 0 of 1 point compared"), HasSubstr("nothing to compare"),
                                   Not(HasSubstr("nan")), Not(HasSubstr("degrees"))));
  const CurvRun rendered = RunCurv({"render", result, "-o", dir_.File("r.png")});
  EXPECT_EQ(rendered.exit_code, 0) << rendered.err;
  EXPECT_THAT(rendered.out, AllOf(HasSubstr("--up=z --view="), Not(HasSubstr("()"))));
}

TEST_F(CurvTest, InfoNamesInstructionSetsAsProcessorsDo) {
  EXPECT_THAT(RunCurv({"info"}).out, AllOf(HasSubstr("instruction set"), Not(HasSubstr("AVX3"))));
}

TEST_F(CurvTest, PlansOfTilesAdviseNormals) {
  const std::string cloud = dir_.Write("bare.xyz", "0 0 0\n1 0 0\n0 1 0\n1 1 0\n");
  const CurvRun run = RunCurv({"tiles", "plan", cloud, "-o", dir_.File("work")});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.err, HasSubstr("curv normals makes them of the positions and writes them into a file"));
  EXPECT_THAT(RunCurv({"tiles", "plan", "--help"}).out,
              AllOf(HasSubstr("normal-regression"), Not(HasSubstr("or auto")), Not(HasSubstr(", auto"))));
}

TEST_F(CurvTest, StatusOfTilesIsSilentOnWhatWasNotRepaired) {
  const std::string work = dir_.File("work");
  EXPECT_EQ(RunCurv({"tiles", "plan", Cloud(), "-o", work}).exit_code, 0);  // one tile
  EXPECT_THAT(RunCurv({"tiles", "run", work}).out, Not(HasSubstr("again")));
  EXPECT_THAT(RunCurv({"tiles", "status", work}).out, AllOf(HasSubstr("done"), Not(HasSubstr("repaired"))));
}

}  // namespace
}  // namespace curv
