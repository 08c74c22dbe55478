// Many files at once.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>

#include "client/cli/files/finished_files.h"
#include "client/io/table_file.h"
#include "tests/client/cli/run_curv.h"
#include "tests/client/temp_dir.h"

namespace curv {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;

class BatchTest : public ::testing::Test {
 protected:
  BatchTest() { fs::create_directory(dir_.File("in")); }

  // A small cloud, an hour old: clocks of file systems are coarse.
  std::string Cloud(const std::string& name) {
    const std::string path = dir_.File("in/" + name);
    const CurvRun run = RunCurv({"generate", "torus", "--points=600", "-o", path});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    fs::last_write_time(path, fs::file_time_type::clock::now() - std::chrono::hours(1));
    return path;
  }

  std::string Out() const { return dir_.File("out/"); }

  const TempDir dir_;
};

TEST_F(BatchTest, EstimatesEveryFile) {
  const std::string a = Cloud("a.ply"), b = Cloud("b.csv"), c = Cloud("c.ply.gz");
  const std::string d = dir_.Write("in/d.obj", "v 0 0 0\nvn 0 0 1\nv 1 0 0\nvn 0 0 1\nv 0 1 0\nvn 0 0 1\n");
  const CurvRun run = RunCurv({"estimate", a, b, c, d, "-o", Out(), "--k=20"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr(a + ": 600 points, 600 ok, "), HasSubstr("-> " + dir_.File("out/b.csv")),
                             HasSubstr("4 files: 4 done, 0 skipped, 0 failed; 1,803 points in ")));
  for (const char* name : {"out/a.ply", "out/b.csv", "out/c.ply", "out/d.ply"}) {
    const absl::StatusOr<PointTable> table = LoadTable(dir_.File(name));
    ASSERT_TRUE(table.ok()) << table.status();
    EXPECT_NE(table->Find("mean_curvature"), nullptr) << name;
  }
  ASSERT_EQ(RunCurv({"estimate", a, "-o", dir_.File("alone.ply"), "--k=20"}).exit_code, 0);
  EXPECT_EQ(dir_.Read("out/a.ply"), dir_.Read("alone.ply"));
}

TEST_F(BatchTest, GoesOnWhereItEnded) {
  const std::string a = Cloud("a.ply"), b = Cloud("b.ply");
  ASSERT_EQ(RunCurv({"estimate", a, "-o", Out(), "--k=20"}).exit_code, 0);
  CurvRun run = RunCurv({"estimate", a, b, "-o", Out(), "--k=20", "--threads=1", "--summary=text"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr(a + ": skipped, " + dir_.File("out/a.ply") + " is finished"),
                             HasSubstr("2 files: 1 done, 1 skipped, 0 failed")));
  EXPECT_THAT(RunCurv({"estimate", a, b, "-o", Out(), "--k=20"}).out, HasSubstr("0 done, 2 skipped"));
  EXPECT_THAT(RunCurv({"estimate", a, b, "-o", Out(), "--k=20", "--force"}).out, HasSubstr("2 done, 0 skipped"));
}

TEST_F(BatchTest, DoesAgainWhatIsOutdated) {
  const std::string a = Cloud("a.ply");
  const auto estimate = [&](const std::string& flag) { return RunCurv({"estimate", a, "-o", Out(), flag}).out; };
  EXPECT_THAT(estimate("--k=20"), HasSubstr("1 done"));
  EXPECT_THAT(estimate("--k=30"), HasSubstr("1 done")) << "other options";
  EXPECT_THAT(estimate("--k=30"), HasSubstr("1 skipped"));
  fs::last_write_time(a, fs::file_time_type::clock::now() + std::chrono::hours(1));
  EXPECT_THAT(estimate("--k=30"), HasSubstr("1 done")) << "a newer input";
  fs::last_write_time(a, fs::file_time_type::clock::now() - std::chrono::hours(1));
  EXPECT_THAT(estimate("--k=30"), HasSubstr("1 skipped"));
  dir_.Write("out/a.ply", "ply\n");
  EXPECT_THAT(estimate("--k=30"), HasSubstr("1 done")) << "an output that somebody has changed";
  fs::remove(dir_.File("out/a.ply"));
  EXPECT_THAT(estimate("--k=30"), HasSubstr("1 done")) << "an output that is gone";
  dir_.Write(std::string("out/") + kFinishedFiles, "{\"output\": \"a.ply\", \"opt");
  EXPECT_THAT(estimate("--k=30"), HasSubstr("1 done")) << "a record that was cut off";
  EXPECT_THAT(estimate("--k=30"), HasSubstr("1 skipped"));
}

// Such a name is no text that JSON can hold.
TEST_F(BatchTest, RemembersNamesThatAreNotUtf8) {
  const std::string a = Cloud("bad\xff.ply"), b = Cloud("bad\xfe.ply");
  ASSERT_EQ(RunCurv({"estimate", a, "-o", Out(), "--k=20"}).exit_code, 0);
  EXPECT_THAT(RunCurv({"estimate", a, b, "-o", Out(), "--k=20"}).out, HasSubstr("2 files: 1 done, 1 skipped"));
  EXPECT_THAT(RunCurv({"estimate", a, b, "-o", Out(), "--k=20"}).out, HasSubstr("2 files: 0 done, 2 skipped"));

  const std::string folder = dir_.File("out"),
                    replaced = dir_.Write("out/bad\xef\xbf\xbd.ply", dir_.Read("out/bad\xff.ply"));
  const FinishedFiles finished(folder, "--k=20");
  EXPECT_TRUE(finished.Has(a, dir_.File("out/bad\xff.ply")));
  EXPECT_FALSE(finished.Has(a, replaced)) << "U+FFFD is another name";
  FinishedFiles other(folder, "--direction-columns=\xff");
  ASSERT_TRUE(other.Add(replaced).ok());
  EXPECT_TRUE(FinishedFiles(folder, "--direction-columns=\xff").Has(a, replaced));
  EXPECT_FALSE(FinishedFiles(folder, "--direction-columns=\xfe").Has(a, replaced));
}

TEST_F(BatchTest, AFailureStopsNoOther) {
  const std::string a = Cloud("a.ply"), bad = dir_.Write("in/bad.ply", "plx\n"), c = Cloud("c.ply");
  CurvRun run = RunCurv({"estimate", a, bad, c, "-o", Out()});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, StartsWith("curv: " + bad + ": line 1"));
  EXPECT_THAT(run.out, AllOf(HasSubstr("3 files: 2 done, 0 skipped, 1 failed"), HasSubstr("failed: " + bad)));
  EXPECT_FALSE(dir_.Has("out/bad.ply"));
  run = RunCurv({"estimate", a, bad, c, "-o", Out(), "--summary=json"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.out,
              AllOf(HasSubstr("\"skipped\":true"), HasSubstr("{\"files\":3,\"done\":0,\"skipped\":2,\"failed\":[\"")));
}

TEST_F(BatchTest, NamesReachNoTerminalAsTheyAre) {
  const std::string a = Cloud("a\x1b[2J.ply"), bad = dir_.Write("in/bad\x1b[2J.ply", "plx\n");
  for (const CurvRun& run :
       {RunCurv({"estimate", a, "-o", dir_.File("\x1b[2J.ply")}), RunCurv({"evaluate", dir_.File("\x1b[2J.ply")}),
        RunCurv({"estimate", a, bad, "-o", Out()})}) {
    EXPECT_THAT(run.out, AllOf(HasSubstr("\\x1b[2J.ply"), Not(HasSubstr("\x1b"))));
    EXPECT_THAT(run.err, Not(HasSubstr("\x1b")));
  }
}

TEST_F(BatchTest, AServerThatIsNotThereEndsIt) {
  const std::string a = Cloud("a.ply"), b = Cloud("b.ply");
  const CurvRun run =
      RunCurv({"estimate", a, b, "-o", Out(), "--server=127.0.0.1:1", "--connect-timeout=0.2", "--max-attempts=1"});
  EXPECT_EQ(run.exit_code, 5);
  EXPECT_THAT(run.out, HasSubstr("0 done, 0 skipped, 0 failed, 2 not tried"));
}

TEST_F(BatchTest, RefusesWhatCannotBeMeant) {
  const std::string a = Cloud("a.ply"), b = Cloud("b.ply");
  const auto message = [](const std::vector<std::string>& words) {
    const CurvRun run = RunCurv(words);
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_THAT(run.out, IsEmpty());
    return run.err;
  };
  EXPECT_THAT(message({"estimate", a, b, "-o", dir_.File("out.ply")}), HasSubstr("2 inputs need a directory"));
  EXPECT_THAT(message({"estimate", a, a, "-o", Out()}), HasSubstr("would both become"));
  EXPECT_THAT(message({"estimate", a, b, "-o", dir_.File("in")}), HasSubstr("would replace the input"));
  EXPECT_THAT(message({"estimate", a, "-", "-o", Out()}), HasSubstr("standard input has no name"));
  EXPECT_FALSE(dir_.Has("out"));
  const CurvRun blocked = RunCurv({"estimate", a, "-o", dir_.Write("file", "") + "/out/"});
  EXPECT_EQ(blocked.exit_code, 4);
  EXPECT_THAT(blocked.err, HasSubstr("cannot make"));
}

TEST_F(BatchTest, FormatNamesTheOutputs) {
  const std::string a = Cloud("a.ply");
  const CurvRun run = RunCurv({"estimate", a, "-o", Out(), "--format=las"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(LoadTable(dir_.File("out/a.las")).ok());
}

}  // namespace
}  // namespace curv
