// The program curvd as an operator runs it.
#include "tests/integration/process.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/rpc/error_reasons.h"
#include "tests/integration/clouds.h"
#include "tests/integration/test_call.h"
#include "tests/integration/test_server.h"

namespace curvd {
namespace {

using ::testing::HasSubstr;

const std::vector<std::string> kAnyPort = {"--listen=127.0.0.1:0", "--metrics-listen=none"};

TEST(ProcessTest, ServesUntilSigtermAndLogsEachCall) {
  Process curvd(kAnyPort);
  const std::string address = ValueIn(curvd.WaitForLine("\"event\":\"serving\""), "listen");
  const TestCloud cloud = Sphere(1'000, 1.0f);
  curvature::v1::CloudHeader header = HeaderFor(cloud);
  header.set_request_tag("a \"quoted\" tag");
  const CallResult result = Estimate(OpenChannel(address), header, cloud);
  EXPECT_TRUE(Succeeded(result, cloud.size()));
  const std::string line = curvd.WaitForLine("\"event\":\"call\"");
  EXPECT_EQ(ValueIn(line, "request_id"), result.request_id);
  EXPECT_THAT(line, HasSubstr("\"tag\":\"a \\\"quoted\\\" tag\""));
  EXPECT_THAT(line, HasSubstr("\"code\":\"OK\""));
  EXPECT_THAT(line, HasSubstr("\"points\":1000"));
  curvd.Signal(SIGTERM);
  EXPECT_EQ(curvd.WaitForExit(), 0);
}

TEST(ProcessTest, TheErrorOfACallLeadsToItsLogLine) {
  Process curvd(kAnyPort);
  const std::string address = ValueIn(curvd.WaitForLine("\"event\":\"serving\""), "listen");
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
  const std::string address = ValueIn(curvd.WaitForLine("\"event\":\"serving\""), "listen");
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
  const std::string address = ValueIn(curvd.WaitForLine("\"event\":\"serving\""), "listen");
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
  const std::string address = ValueIn(curvd.WaitForLine("\"event\":\"serving\""), "listen");
  TestCall call(OpenChannel(address));
  ASSERT_TRUE(call.SendHeader({}));
  call.ReadAccepted();
  curvd.Signal(SIGTERM);
  curvd.WaitForLine("\"event\":\"draining\"");
  curvd.Signal(SIGTERM);
  EXPECT_EQ(curvd.WaitForExit(), 3);
  EXPECT_EQ(call.Finish().status.error_code(), grpc::StatusCode::UNAVAILABLE);
}

// Others read their files again then; curvd does so by itself.
TEST(ProcessTest, AHangupChangesNothing) {
  Process curvd(kAnyPort);
  const std::string address = ValueIn(curvd.WaitForLine("\"event\":\"serving\""), "listen");
  TestCall call(OpenChannel(address));
  ASSERT_TRUE(call.SendHeader({}));
  call.ReadAccepted();
  curvd.Signal(SIGHUP);
  const TestCloud cloud = Sphere(1'000, 1.0f);
  ASSERT_TRUE(call.SendCloud(cloud, 1'000));
  call.HalfClose();
  EXPECT_TRUE(Succeeded(call.Finish(), cloud.size()));
  curvd.Signal(SIGTERM);
  EXPECT_EQ(curvd.WaitForExit(), 0);
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
  const std::string metrics = ValueIn(line, "metrics_listen");
  const int port = std::stoi(metrics.substr(metrics.rfind(':') + 1));
  EXPECT_THAT(HttpGet(port, "/metrics"), HasSubstr("\ncurvd_workers 5\n"));
}

TEST(ProcessTest, OthersReachItInPlainTextOnlyIfTheOperatorInsists) {
  Process curvd({"--listen=0.0.0.0:0", "--metrics-listen=none"});
  EXPECT_THAT(curvd.ReadAll(), ::testing::AllOf(HasSubstr("--listen is 0.0.0.0:0"), HasSubstr("--insecure")));
  EXPECT_EQ(curvd.WaitForExit(), 2);
}

TEST(ProcessTest, WarnsWhenOthersCanReachIt) {
  Process curvd({"--listen=0.0.0.0:0", "--insecure", "--metrics-listen=none"});
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
  EXPECT_THAT(curvd.ReadAll(), HasSubstr("--threads: \"-3\" must be a whole number of 0 or more"));
  EXPECT_EQ(curvd.WaitForExit(), 2);
}

TEST(ProcessTest, FilesThatCannotBeReadAreWrongFlags) {
  Process curvd({"--listen=127.0.0.1:0", "--metrics-listen=none", "--token-file=/nowhere/file"});
  curvd.WaitForLine("--token-file: cannot read /nowhere/file: No such file");
  EXPECT_EQ(curvd.WaitForExit(), 2);
  Process holds_no_token({"--listen=127.0.0.1:0", "--metrics-listen=none", "--token-file=/etc/passwd"});
  EXPECT_EQ(holds_no_token.WaitForExit(), 1);
}

TEST(ProcessTest, LogsVariablesThatNoFlagReads) {
  Process curvd(kAnyPort, {{"CURVD_LISTN", "0.0.0.0:1"}});
  EXPECT_THAT(curvd.WaitForLine("unknown_variable"), HasSubstr("did you mean CURVD_LISTEN?"));
}

}  // namespace
}  // namespace curvd
