// The program curvd as an operator runs it.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <regex>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/reasons.h"
#include "tests/integration/clouds.h"
#include "tests/integration/test_call.h"
#include "tests/integration/test_server.h"

namespace curvd {
namespace {

using ::testing::HasSubstr;

// A curvd process whose output is read here.
class Process {
 public:
  explicit Process(std::vector<std::string> arguments,
                   const std::vector<std::pair<std::string, std::string>>& environment = {}) {
    int ends[2];
    EXPECT_EQ(pipe(ends), 0);
    arguments.insert(arguments.begin(), CURVD_BINARY);
    std::vector<char*> argv;
    argv.reserve(arguments.size() + 1);
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    pid_ = fork();
    if (pid_ == 0) {
      dup2(ends[1], STDOUT_FILENO);
      dup2(ends[1], STDERR_FILENO);
      close(ends[0]);
      for (const auto& [name, value] : environment) setenv(name.c_str(), value.c_str(), 1);
      execv(argv[0], argv.data());
      _exit(127);
    }
    close(ends[1]);
    output_ = fdopen(ends[0], "r");
  }
  ~Process() {
    if (!waited_) {
      Signal(SIGKILL);
      WaitForExit();
    }
    fclose(output_);
  }

  void Signal(int number) const { kill(pid_, number); }
  // The next line of output that contains `text`; fails the test if there is none.
  std::string WaitForLine(const std::string& text) {
    char* line = nullptr;
    size_t capacity = 0;
    std::string found;
    while (found.empty() && getline(&line, &capacity, output_) > 0) {
      if (std::string(line).find(text) != std::string::npos) found = line;
    }
    free(line);
    EXPECT_FALSE(found.empty()) << "no line with " << text;
    return found;
  }
  // All that is left to read.
  std::string ReadAll() {
    std::string text;
    for (int c = fgetc(output_); c != EOF; c = fgetc(output_)) text += static_cast<char>(c);
    return text;
  }
  // The exit status, or minus the number of the signal that ended it.
  int WaitForExit() {
    int status = 0;
    waitpid(pid_, &status, 0);
    waited_ = true;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

 private:
  pid_t pid_ = -1;
  FILE* output_ = nullptr;
  bool waited_ = false;
};

std::string AddressIn(const std::string& line, const std::string& key) {
  std::smatch match;
  const std::regex pattern("\"" + key + "\":\"([^\"]*)\"");
  return std::regex_search(line, match, pattern) ? match[1].str() : "";
}

const std::vector<std::string> kAnyPort = {"--listen=127.0.0.1:0", "--metrics-listen=none"};

TEST(ProcessTest, ServesUntilSigtermAndLogsEachCall) {
  Process curvd(kAnyPort);
  const std::string address = AddressIn(curvd.WaitForLine("\"event\":\"serving\""), "listen");
  const TestCloud cloud = Sphere(1'000, 1.0f);
  curvature::v1::CloudHeader header = HeaderFor(cloud);
  header.set_request_tag("a \"quoted\" tag");
  const CallResult result = Estimate(OpenChannel(address), header, cloud);
  EXPECT_TRUE(Succeeded(result, cloud.size()));
  const std::string line = curvd.WaitForLine("\"event\":\"call\"");
  EXPECT_EQ(AddressIn(line, "request_id"), result.request_id);
  EXPECT_THAT(line, HasSubstr("\"tag\":\"a \\\"quoted\\\" tag\""));
  EXPECT_THAT(line, HasSubstr("\"code\":\"OK\""));
  EXPECT_THAT(line, HasSubstr("\"points\":1000"));
  curvd.Signal(SIGTERM);
  EXPECT_EQ(curvd.WaitForExit(), 0);
}

TEST(ProcessTest, TheErrorOfACallLeadsToItsLogLine) {
  Process curvd(kAnyPort);
  const std::string address = AddressIn(curvd.WaitForLine("\"event\":\"serving\""), "listen");
  curvature::v1::CloudHeader header;
  header.mutable_options()->set_neighbor_count(1);
  const CallResult result = Estimate(OpenChannel(address), header, Sphere(10, 1.0f));
  EXPECT_TRUE(FailedWith(result, grpc::StatusCode::INVALID_ARGUMENT, kReasonInvalidOption, {"neighbor_count"}));
  const std::string line = curvd.WaitForLine(result.metadata.at("request_id"));
  EXPECT_THAT(line, HasSubstr("\"code\":\"INVALID_ARGUMENT\",\"reason\":\"INVALID_OPTION\""));
  EXPECT_THAT(line, HasSubstr("\"level\":\"warning\""));
}

TEST(ProcessTest, DrainsAtSigtermUnderLoad) {
  Process curvd(kAnyPort);
  const std::string address = AddressIn(curvd.WaitForLine("\"event\":\"serving\""), "listen");
  const std::shared_ptr<grpc::Channel> channel = OpenChannel(address);
  const TestCloud cloud = Sphere(20'000, 1.0f);
  std::vector<std::unique_ptr<TestCall>> calls;
  for (int i = 0; i < 4; ++i) {
    calls.push_back(std::make_unique<TestCall>(channel));
    ASSERT_TRUE(calls.back()->SendHeader(HeaderFor(cloud)));
    calls.back()->ReadAccepted();
  }
  curvd.Signal(SIGTERM);
  curvd.WaitForLine("\"event\":\"draining\"");
  for (const auto& call : calls) {
    ASSERT_TRUE(call->SendCloud(cloud, 4'000));
    call->HalfClose();
    EXPECT_TRUE(Succeeded(call->Finish(), cloud.size()));
  }
  EXPECT_EQ(curvd.WaitForExit(), 0);
}

TEST(ProcessTest, EndsUnfinishedCallsAtTheDrainTimeout) {
  Process curvd({"--listen=127.0.0.1:0", "--metrics-listen=none", "--drain-timeout=100ms"});
  const std::string address = AddressIn(curvd.WaitForLine("\"event\":\"serving\""), "listen");
  TestCall call(OpenChannel(address));
  ASSERT_TRUE(call.SendHeader({}));
  call.ReadAccepted();
  curvd.Signal(SIGINT);
  EXPECT_TRUE(
      FailedWith(call.Finish(), grpc::StatusCode::UNAVAILABLE, kReasonDrainTimeout, {"100ms", "drain_timeout"}));
  EXPECT_EQ(curvd.WaitForExit(), 0);
}

TEST(ProcessTest, ASecondSignalEndsAtOnce) {
  Process curvd({"--listen=127.0.0.1:0", "--metrics-listen=none", "--drain-timeout=10m"});
  const std::string address = AddressIn(curvd.WaitForLine("\"event\":\"serving\""), "listen");
  TestCall call(OpenChannel(address));
  ASSERT_TRUE(call.SendHeader({}));
  call.ReadAccepted();
  curvd.Signal(SIGTERM);
  curvd.WaitForLine("\"event\":\"draining\"");
  curvd.Signal(SIGTERM);
  EXPECT_EQ(curvd.WaitForExit(), 3);
  EXPECT_EQ(call.Finish().status.error_code(), grpc::StatusCode::UNAVAILABLE);
}

TEST(ProcessTest, ASecondServerOnThePortFailsWithAClearError) {
  TestServer first;
  Process second({"--listen=" + first.address(), "--metrics-listen=none"});
  EXPECT_THAT(second.WaitForLine("curvd: "), HasSubstr(first.address()));
  EXPECT_EQ(second.WaitForExit(), 1);
}

TEST(ProcessTest, TakesItsFlagsFromTheEnvironmentToo) {
  Process curvd({}, {{"CURVD_LISTEN", "127.0.0.1:0"}, {"CURVD_METRICS_LISTEN", "127.0.0.1:0"}, {"CURVD_THREADS", "5"}});
  const std::string line = curvd.WaitForLine("\"event\":\"serving\"");
  const std::string metrics = AddressIn(line, "metrics_listen");
  const int port = std::stoi(metrics.substr(metrics.rfind(':') + 1));
  EXPECT_THAT(HttpGet(port, "/metrics"), HasSubstr("\ncurvd_workers 5\n"));
}

TEST(ProcessTest, WarnsWhenOthersCanReachIt) {
  Process curvd({"--listen=0.0.0.0:0", "--metrics-listen=none"});
  EXPECT_THAT(curvd.WaitForLine("\"event\":\"unencrypted\""), HasSubstr("\"level\":\"warning\""));
}

TEST(ProcessTest, HelpTeaches) {
  Process curvd({"--help"});
  const std::string text = curvd.ReadAll();
  EXPECT_EQ(curvd.WaitForExit(), 0);
  EXPECT_THAT(text, HasSubstr("--listen"));
  EXPECT_THAT(text, HasSubstr("CURVD_LISTEN"));
}

TEST(ProcessTest, BadFlagsAreNamed) {
  Process curvd({"--threads=-3"});
  EXPECT_THAT(curvd.ReadAll(), HasSubstr("--threads is -3"));
  EXPECT_EQ(curvd.WaitForExit(), 2);
}

}  // namespace
}  // namespace curvd
