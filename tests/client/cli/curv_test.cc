// The program as users meet it: exit codes, messages, files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "absl/strings/str_cat.h"
#include "client/io/table_file.h"
#include "server/curvature_server.h"
#include "tests/client/cli/run_curv.h"
#include "tests/client/temp_dir.h"

namespace curv {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::IsSupersetOf;
using ::testing::Not;
using ::testing::StartsWith;

std::vector<std::string> ColumnNames(const PointTable& table) {
  std::vector<std::string> names;
  for (const Column& column : table.columns()) names.push_back(column.name);
  return names;
}

class CurvTest : public ::testing::Test {
 protected:
  // A small cloud with normals and truth.
  std::string Cloud(const std::string& surface = "torus", const std::string& points = "2000") {
    const std::string path = dir_.File(surface + ".ply");
    const CurvRun run = RunCurv({"generate", surface, "--points=" + points, "-o", path});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return path;
  }

  const TempDir dir_;
};

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

TEST_F(CurvTest, SummariesWithoutRangesHaveNone) {
  std::vector<std::string> words = {"estimate", Cloud(), "-o", dir_.File("r.ply"), "--quantities=radius"};
  const CurvRun text = RunCurv(words);
  ASSERT_EQ(text.exit_code, 0) << text.err;
  EXPECT_THAT(text.out, Not(HasSubstr("median")));
  words.push_back("--summary=json");
  EXPECT_THAT(RunCurv(words).out, HasSubstr("\"ranges\":{},"));
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

TEST_F(CurvTest, RefusalsNameThePointAndTheWayOut) {
  const std::string input = dir_.Write("nan.xyz", "1 2 3 0 0 1\n1 2 nan 0 0 1\n");
  const CurvRun refused = RunCurv({"estimate", input, "-o", dir_.File("out.ply")});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.err, AllOf(HasSubstr("INVALID_ARGUMENT"), HasSubstr("1"), HasSubstr("--on-invalid=skip")));
  EXPECT_EQ(RunCurv({"estimate", input, "-o", dir_.File("out.ply"), "--on-invalid=skip"}).exit_code, 0);
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
  EXPECT_FALSE(dir_.Has("out.ply"));
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

TEST_F(CurvTest, SaysWhenNoPointCouldBeEstimated) {
  const CurvRun run = RunCurv({"estimate", Cloud(), "-o", dir_.File("r.ply"), "--k=5000"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.err, HasSubstr("no point could be estimated"));
}

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

TEST_F(CurvTest, ChoosesEstimatorAndScale) {
  const std::string cloud = Cloud("sphere", "3000"), out = dir_.File("out.ply");
  const CurvRun run = RunCurv({"estimate", cloud, "-o", out, "--auto"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, IsEmpty());
  EXPECT_THAT(run.out, AllOf(HasSubstr("3,000 points, auto, K = auto"), HasSubstr("\n  chosen by "),
                             HasSubstr("\n  jet "), HasSubstr(" %\n")));
  const std::string by_short = dir_.Read("out.ply");
  ASSERT_EQ(RunCurv({"estimate", cloud, "-o", out, "--estimator=auto", "--k=auto"}).exit_code, 0);
  EXPECT_EQ(dir_.Read("out.ply"), by_short);
  ASSERT_EQ(RunCurv({"estimate", cloud, "-o", out, "--estimator=auto"}).exit_code, 0);
  EXPECT_EQ(dir_.Read("out.ply"), by_short) << "auto leaves K open too";
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
                             HasSubstr(R"({"estimator":"jet","neighbor_count":100,)")));
  EXPECT_THAT(summary({"--k=100"}), AllOf(Not(HasSubstr("\"scale\":")), HasSubstr("\"jet_degree\":2")));
  EXPECT_THAT(RunCurv({"estimate", cloud, "-o", out, "--auto", "--max-radius=1e-9"}).err,
              HasSubstr("no point could be estimated"));
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
  EXPECT_THAT(message({"--k=auto", "--estimator=hexagram"}, 1), HasSubstr("it must be auto, avg-hexagram"));
  EXPECT_THAT(message({"--k=100", "--estimator=aso", "--also=standard_errors"}, 1),
              HasSubstr("project is false; it must be true"));
  EXPECT_THAT(message({"--k=auto", "--estimator=jet", "--jet-degree=2"}, 1),
              HasSubstr("jet_degree is 2; it must be 4"));
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

TEST_F(CurvTest, NotesWhatItLeavesOut) {
  const CurvRun run =
      RunCurv({"estimate", dir_.Write("o.obj", "v 0 0 0\nv 1 0 0\nvn 0 0 1\n"), "-o", dir_.File("r.csv")});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.err, HasSubstr("note: "));
  EXPECT_THAT(run.err, Not(HasSubstr("terminate")));
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
  EXPECT_THAT(RunCurv({"estimate", cloud, "-o", out, "--k=16,64", "--estimator=jet"}).err,
              HasSubstr("one of avg-hexagram, normal-regression"));
}

}  // namespace
}  // namespace curv
