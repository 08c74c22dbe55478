// Named pipes as input and output, and signals while curv waits for whoever is at their other end.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

#include "tests/client/cli/curv_fixture.h"

namespace curv {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;

// Far more than anything here takes. What waits for ever is killed then, with exit code 137.
constexpr int kMostSeconds = 120;
constexpr int kInterrupted = 130;

class PipesTest : public CurvTest {
 protected:
  std::string Pipe(const std::string& name) {
    const std::string path = dir_.File(name);
    EXPECT_EQ(mkfifo(path.c_str(), 0600), 0);
    return path;
  }

  // Sends the first signal to a run that waits, and expects that it ends with the documented code and leaves no file
  // beside the `files` that there were before it began: it makes one for a moment to see whether it may.
  void ExpectInterrupted(RunningCurv& run, int signal, const std::string& what, size_t files) {
    run.Signal(signal);
    const CurvRun ended = run.Wait(kMostSeconds);
    EXPECT_EQ(ended.exit_code, kInterrupted) << what << ended.err;
    EXPECT_THAT(ended.err, EndsWith("curv: interrupted\n")) << what;
    EXPECT_EQ(dir_.FileCount(), files) << what;
  }
};

TEST_F(PipesTest, ANamedPipeGetsTheWholeResult) {
  const std::string cloud = Cloud(), pipe = Pipe("pipe.ply");
  const std::vector<std::string> kCommands[] = {
      {"estimate", cloud}, {"normals", cloud}, {"select", cloud, "--where=x > 0"}};
  for (std::vector<std::string> command : kCommands) {
    command.insert(command.end(), {"-o", dir_.File("file.ply")});
    ASSERT_EQ(RunCurv(command).exit_code, 0);
    command.back() = pipe;
    std::string read;
    RunningCurv run(command);
    std::thread reader([&] {
      std::ifstream file(pipe, std::ios::binary);
      read.assign(std::istreambuf_iterator<char>(file), {});
    });
    EXPECT_EQ(run.Wait(kMostSeconds).exit_code, 0) << command.front();
    reader.join();
    EXPECT_EQ(read, dir_.Read("file.ply")) << command.front();
  }
}

TEST_F(PipesTest, TheFirstSignalEndsWhatWaitsForStandardInput) {
  const std::string pipe = Pipe("in");
  const int writer = open(pipe.c_str(), O_RDWR | O_CLOEXEC);  // which writes nothing
  for (const char* command : {"estimate", "normals", "orient"}) {
    for (const int signal : {SIGTERM, SIGINT}) {
      const size_t files = dir_.FileCount();
      RunningCurv run({command, "-", "-o", dir_.File("out.ply"), "--format=ply"}, pipe);
      run.AwaitInterruptWatch();
      ExpectInterrupted(run, signal, command, files);
    }
  }
  close(writer);
}

TEST_F(PipesTest, TheFirstSignalEndsWhatWaitsForAWriter) {
  const std::string pipe = Pipe("in.ply");
  for (const std::string output : {"out.ply", "results/"}) {
    if (output.ends_with('/')) mkdir(dir_.File(output).c_str(), 0700);
    const size_t files = dir_.FileCount();
    RunningCurv run({"estimate", pipe, "-o", dir_.File(output)});
    run.AwaitInterruptWatch();
    ExpectInterrupted(run, SIGTERM, output, files);
  }
  const size_t files = dir_.FileCount();
  RunningCurv view({"view", pipe});
  view.AwaitInterruptWatch();
  ExpectInterrupted(view, SIGTERM, "view", files);
}

TEST_F(PipesTest, TheFirstSignalEndsWhatWaitsForAReader) {
  const std::string cloud = Cloud("torus", "10000"), pipe = Pipe("out.ply");  // more than a pipe holds
  for (const char* command : {"estimate", "normals", "orient"}) {
    const size_t files = dir_.FileCount();
    RunningCurv run({command, cloud, "-o", pipe});
    const int reader = open(pipe.c_str(), O_RDONLY | O_CLOEXEC);  // waits until curv writes
    ExpectInterrupted(run, SIGTERM, command, files);
    close(reader);
  }
  const std::vector<std::string> kWithoutServer[] = {{"select", cloud, "--where=x > -1e9"},
                                                     {"generate", "torus", "--points=10000"}};
  for (std::vector<std::string> command : kWithoutServer) {
    command.insert(command.end(), {"-o", pipe});
    const size_t files = dir_.FileCount();
    RunningCurv run(command);
    run.AwaitInterruptWatch();  // before the pipe has a reader
    ExpectInterrupted(run, SIGTERM, command.front(), files);
  }
}

TEST_F(PipesTest, ASignalWhileAFileIsWrittenLetsItBeFinished) {
  const std::string cloud = Cloud("torus", "50000");
  const std::vector<std::string> kCommands[] = {{"generate", "torus", "--points=50000", "-o", dir_.File("out.csv")},
                                                {"select", cloud, "--where=x > -1e9", "-o", dir_.File("out.xyz")},
                                                {"render", cloud, "--size=1600x1200", "-o", dir_.File("out.png")},
                                                {"report", cloud, "-o", dir_.File("out.html")}};
  for (const std::vector<std::string>& command : kCommands) {
    const size_t files = dir_.FileCount();
    RunningCurv run(command);
    run.AwaitInterruptWatch();  // which begins with the write
    run.Signal(SIGTERM);
    EXPECT_EQ(run.Wait(kMostSeconds).exit_code, 0) << command.front();
    EXPECT_TRUE(dir_.Has(command.back())) << command.front();
    EXPECT_EQ(dir_.FileCount(), files + 1) << command.front() << " leaves a temporary file";
  }
}

TEST_F(PipesTest, TilesRefuseOneAtOnce) {
  RunningCurv run({"tiles", "plan", Pipe("in.ply"), "-o", dir_.File("work")});
  const CurvRun refused = run.Wait(kMostSeconds);
  EXPECT_EQ(refused.exit_code, 3);
  EXPECT_THAT(refused.err, HasSubstr("in.ply: it is no regular file"));
}

}  // namespace
}  // namespace curv
