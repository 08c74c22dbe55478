// Standard input and output in place of files, and files that gzip has packed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/io/table_file.h"
#include "tests/client/cli/run_curv.h"
#include "tests/client/io/samples.h"
#include "tests/client/temp_dir.h"

namespace curv {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

class StreamsTest : public ::testing::Test {
 protected:
  // A torus of 1,000 points in a file of that name.
  std::string Cloud(const std::string& name) {
    const CurvRun run = RunCurv({"generate", "torus", "--points=1000", "--double", "-o", dir_.File(name)});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return dir_.File(name);
  }
  std::vector<double> MeanOf(const std::string& path) {
    const absl::StatusOr<PointTable> table = LoadTable(path);
    EXPECT_TRUE(table.ok()) << table.status();
    return table.ok() ? Values(*table, "mean_curvature") : std::vector<double>();
  }

  const TempDir dir_;
};

TEST_F(StreamsTest, EstimatesWhatComesIn) {
  const std::string cloud = Cloud("cloud.ply");
  ASSERT_EQ(RunCurv({"estimate", cloud, "-o", dir_.File("expected.ply")}).exit_code, 0);
  const std::vector<double> expected = MeanOf(dir_.File("expected.ply"));
  ASSERT_EQ(expected.size(), 1000u);
  for (const std::string format : {"ply", "pcd", "xyz", "npy", "las", "csv", "npz"}) {
    const std::string input = Cloud("in." + format);
    const CurvRun run = RunCurv({"estimate", "-", "-o", "-", "--format=" + format}, input);
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_THAT(run.err,
                AllOf(HasSubstr("1,000 points"), HasSubstr("standard input: "), HasSubstr("wrote standard output")))
        << "all messages are on stderr";
    const std::vector<double> mean = MeanOf(dir_.Write("out." + format, run.out));
    ASSERT_EQ(mean.size(), expected.size()) << format;
    for (size_t i = 0; i < mean.size(); ++i) EXPECT_NEAR(mean[i], expected[i], 1e-6 * 0.3) << format;
  }
}

TEST_F(StreamsTest, EachEndMayHaveAFormatOfItsOwn) {
  const std::string cloud = Cloud("in.xyz");
  const std::vector<std::string> kFormats[] = {{"--input-format=xyz", "--output-format=csv"},
                                               {"--format=xyz", "--output-format=csv"},
                                               {"--output-format=csv", "--format=xyz"},
                                               {"--input-format=xyz", "--format=csv"}};
  for (const std::vector<std::string>& formats : kFormats) {
    for (std::vector<std::string> arguments : {std::vector<std::string>{"estimate", "-", "-o", "-"},
                                               {"normals", "-", "-o", "-"},
                                               {"select", "-", "-o", "-", "--where=x > 0"}}) {
      arguments.insert(arguments.end(), formats.begin(), formats.end());
      const CurvRun run = RunCurv(arguments, cloud);
      EXPECT_EQ(run.exit_code, 0) << arguments.front() << formats.front() << run.err;
      EXPECT_THAT(run.out, StartsWith("x,y,z,nx,ny,nz")) << arguments.front();
    }
  }
  const CurvRun obj = RunCurv({"estimate", "-", "-o", "-", "--input-format=xyz", "--output-format=obj"}, cloud);
  EXPECT_EQ(obj.exit_code, 2);
  EXPECT_THAT(RunCurv({"estimate", "-", "-o", "-", "--output-format=csv"}, cloud).err,
              HasSubstr("the name - does not tell a format"));
}

TEST_F(StreamsTest, WhatAFullDiskTakesOfStandardOutputIsNoSuccess) {
  const std::string cloud = Cloud("cloud.ply");
  const std::vector<std::string> runs[] = {{"estimate", cloud, "-o", dir_.File("out.ply"), "--summary=json"},
                                           {"completion", "bash"},
                                           {"--help"},
                                           {"info", "--json"}};
  for (const std::vector<std::string>& arguments : runs) {
    const CurvRun run = RunCurv(arguments, "", "/dev/full");
    EXPECT_EQ(run.exit_code, 4) << arguments.front();
    EXPECT_THAT(run.err, HasSubstr("standard output cannot be written"));
  }
}

// By that name a file behind it would be replaced, and the summary be written over its start.
TEST_F(StreamsTest, OtherNamesOfStandardOutputAreStandardOutput) {
  const std::string cloud = Cloud("cloud.ply");
  for (const std::string name : {"/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"}) {
    const std::vector<std::string> runs[] = {{"estimate", cloud, "-o", name, "--format=csv"},
                                             {"normals", cloud, "-o", name, "--format=csv"},
                                             {"select", cloud, "--where", "x > 0", "-o", name, "--format=csv"},
                                             {"generate", "sphere", "--points=100", "-o", name, "--format=csv"}};
    for (const std::vector<std::string>& arguments : runs) {
      const CurvRun run = RunCurv(arguments, "", dir_.Write("redirected", ""));
      EXPECT_EQ(run.exit_code, 0) << run.err;
      EXPECT_THAT(run.err, HasSubstr("standard output")) << arguments.front();
      const absl::StatusOr<PointTable> table = LoadTable(dir_.File("redirected"), "csv");
      EXPECT_TRUE(table.ok()) << arguments.front() << " " << name << ": " << table.status();
    }
  }
}

TEST_F(StreamsTest, FilesKeepTheFormatOfTheirNames) {
  const CurvRun run = RunCurv({"estimate", Cloud("in.csv"), "-o", "-", "--format=ply", "--summary=json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, StartsWith("ply\n"));
  EXPECT_THAT(run.err, StartsWith("{\"input\":"));
  const std::string odd = dir_.Write("scan.dat", dir_.Read("in.csv"));
  EXPECT_EQ(RunCurv({"estimate", odd, "-o", dir_.File("out.ply"), "--format=csv"}).exit_code, 0);
  EXPECT_THAT(dir_.Read("out.ply"), StartsWith("ply\n"));
}

TEST_F(StreamsTest, NormalsGenerateAndEvaluateTakeThemToo) {
  const CurvRun cloud = RunCurv({"generate", "sphere", "--points=500", "-o", "-", "--format=ply"});
  ASSERT_EQ(cloud.exit_code, 0) << cloud.err;
  EXPECT_THAT(cloud.err, HasSubstr("500 points"));
  const std::string input = dir_.Write("sphere", cloud.out);
  const CurvRun normals = RunCurv({"normals", "-", "-o", "-", "--format=ply"}, input);
  ASSERT_EQ(normals.exit_code, 0) << normals.err;
  EXPECT_THAT(normals.out, AllOf(StartsWith("ply\n"), HasSubstr("normal_residual")));
  const CurvRun result = RunCurv({"estimate", "-", "-o", "-", "--format=ply"}, input);
  const CurvRun evaluate = RunCurv({"evaluate", "-", "--format=ply"}, dir_.Write("result", result.out));
  EXPECT_EQ(evaluate.exit_code, 0) << evaluate.err;
  EXPECT_THAT(evaluate.out, HasSubstr("500 of 500"));
}

TEST_F(StreamsTest, NamesWhatIsMissing) {
  const std::string cloud = Cloud("cloud.ply");
  const CurvRun no_format = RunCurv({"estimate", "-", "-o", dir_.File("out.ply")}, cloud);
  EXPECT_EQ(no_format.exit_code, 3);
  EXPECT_THAT(no_format.err, HasSubstr("say --format=ply"));
  EXPECT_EQ(RunCurv({"estimate", cloud, "-o", "-"}).exit_code, 4);
  EXPECT_EQ(RunCurv({"estimate", cloud, "-o", "-", "--format=doc"}).exit_code, 2);
  const CurvRun obj = RunCurv({"estimate", cloud, "-o", "-", "--format=obj"});
  EXPECT_EQ(obj.exit_code, 4);
  EXPECT_THAT(obj.err, HasSubstr("\".obj\" cannot be written: it must be one of .ply"));
  const CurvRun wrong = RunCurv({"estimate", "-", "-o", "-", "--format=las"}, cloud);
  EXPECT_EQ(wrong.exit_code, 3);
  EXPECT_THAT(wrong.err, HasSubstr("standard input: the signature of the file is \"ply?\""));
  EXPECT_THAT(wrong.out, IsEmpty());
}

TEST_F(StreamsTest, GzipIsUnpackedAndPacked) {
  const std::string cloud = Cloud("cloud.ply");
  ASSERT_EQ(RunCurv({"estimate", cloud, "-o", dir_.File("expected.ply")}).exit_code, 0);
  for (const std::string format : {"ply", "xyz", "las"}) {
    const std::string packed = Cloud("in." + format + ".gz");
    EXPECT_THAT(dir_.Read("in." + format + ".gz"), StartsWith("\x1f\x8b"));
    const CurvRun run = RunCurv({"estimate", packed, "-o", dir_.File("out.ply.gz")});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_THAT(dir_.Read("out.ply.gz"), StartsWith("\x1f\x8b"));
    EXPECT_EQ(MeanOf(dir_.File("out.ply.gz")).size(), 1000u);
  }
  // By its bytes, whatever the name says.
  const CurvRun piped = RunCurv({"estimate", "-", "-o", dir_.File("piped.ply"), "--format=ply"}, Cloud("p.ply.gz"));
  ASSERT_EQ(piped.exit_code, 0) << piped.err;
  EXPECT_EQ(MeanOf(dir_.File("piped.ply")), MeanOf(dir_.File("expected.ply")));
  const std::string bytes = dir_.Read("p.ply.gz");
  const CurvRun cut =
      RunCurv({"estimate", dir_.Write("cut.ply.gz", bytes.substr(0, bytes.size() / 2)), "-o", "-", "--format=ply"});
  EXPECT_EQ(cut.exit_code, 3);
  EXPECT_THAT(cut.err, HasSubstr("cut.ply.gz: the gzip data is damaged or cut off"));
}

}  // namespace
}  // namespace curv
