#include "server/observe/server_log.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <string>
#include <thread>

#include "server/rpc/error_detail.h"
#include "server/rpc/error_reasons.h"

namespace curvd {
namespace {

using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::Not;

CallRecord Record() {
  CallRecord record;
  record.request_id = "0badcafe-7";
  record.peer = "ipv4:127.0.0.1:1";
  record.request_tag = "scan \"7\"";
  record.points_received = 12;
  record.seconds.estimate = 0.25;
  return record;
}

TEST(CallLineTest, TellsWhatACallWas) {
  const std::string line = CallLine(Record()).str();
  for (const char* text : {R"("request_id":"0badcafe-7")", R"("tag":"scan \"7\"")", R"("code":"OK")", R"("points":12)",
                           R"("estimate_seconds":0.25)", R"("received_bytes":0)"}) {
    EXPECT_THAT(line, HasSubstr(text));
  }
  EXPECT_THAT(line, Not(HasSubstr("reason")));
  EXPECT_THAT(line, Not(HasSubstr("send_seconds")));  // it never came there
}

TEST(CallLineTest, NamesTheRpc) {
  CallRecord record = Record();
  EXPECT_THAT(CallLine(record).str(), HasSubstr(R"("method":"EstimateCurvature")"));
  record.method = RpcMethod::kGetServerInfo;
  EXPECT_THAT(CallLine(record).str(), HasSubstr(R"("method":"GetServerInfo")"));
}

TEST(CallLineTest, TellsWhyACallFailed) {
  CallRecord record = Record();
  record.status = MakeError(absl::StatusCode::kInvalidArgument, {kReasonInvalidOption, "k", "3", "at least 4", {}});
  const std::string line = CallLine(record).str();
  for (const char* text : {R"("code":"INVALID_ARGUMENT")", R"("reason":"INVALID_OPTION")", "k is 3"}) {
    EXPECT_THAT(line, HasSubstr(text));
  }
}

TEST(ServerLogTest, WritesOneJsonObjectALine) {
  ::testing::internal::CaptureStderr();
  {
    ServerLog log(true);
    log.Log(ServerLog::Level::kWarning, "hello", JsonLine().Add("text", "100 %v {} %d"));
    log.Log(ServerLog::Level::kInfo, "bare", JsonLine());
    log.LogCall(Record());
  }
  const std::string text = ::testing::internal::GetCapturedStderr();
  EXPECT_THAT(text, HasSubstr(R"("level":"warning","event":"hello","text":"100 %v {} %d"})"));
  EXPECT_THAT(text, HasSubstr(R"("level":"info","event":"bare"})"));
  EXPECT_THAT(text, HasSubstr(R"("level":"info","event":"call","request_id":"0badcafe-7")"));
  EXPECT_THAT(text, MatchesRegex("(\\{\"time\":\"[-0-9]+T[:.0-9]+Z\",[^\n]*\\}\n)+"));
}

TEST(ServerLogTest, NobodyForgesALine) {
  CallRecord record = Record();
  record.request_tag = "x\"}\n{\"level\":\"error\",\"event\":\"forged\"}\r\n\x1b[2J\xff";
  record.peer = record.request_tag;
  record.status = absl::InvalidArgumentError(record.request_tag);
  ::testing::internal::CaptureStderr();
  ServerLog(true).LogCall(record);
  const std::string text = ::testing::internal::GetCapturedStderr();
  EXPECT_EQ(text.find('\n'), text.size() - 1);
  EXPECT_THAT(text, Not(HasSubstr("\"event\":\"forged\"")));
  for (const unsigned char c : text.substr(0, text.size() - 1)) EXPECT_TRUE(c >= ' ' && c != 0x7f) << int{c};
}

TEST(ServerLogTest, CallsThatNobodyLetInHaveAFewLinesASecond) {
  CallRecord refused = Record();
  refused.status = absl::UnauthenticatedError("no token");
  CallRecord let_in = Record();
  let_in.caller = "alice";
  let_in.status = absl::InvalidArgumentError("a call of Alice");
  ::testing::internal::CaptureStderr();
  {
    ServerLog log(true);
    for (int i = 0; i < 1'000; ++i) log.LogCall(refused);
    for (int i = 0; i < 1'000; ++i) log.LogCall(let_in);
  }
  const std::string text = ::testing::internal::GetCapturedStderr();
  const auto lines_with = [&text](const std::string& words) {
    int count = 0;
    for (size_t at = 0; (at = text.find(words, at)) != std::string::npos; ++at) ++count;
    return count;
  };
  EXPECT_GE(lines_with("no token"), LogRateLimit::kLinesPerSecond);
  // On a machine that takes less than ten seconds for a thousand.
  EXPECT_LE(lines_with("no token"), 10 * LogRateLimit::kLinesPerSecond);
  EXPECT_EQ(lines_with("a call of Alice"), 1'000);
}

TEST(ServerLogTest, CanBeSilentAboutCalls) {
  ::testing::internal::CaptureStderr();
  ServerLog(false).LogCall(Record());
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

TEST(ServerLogTest, CountsLinesThatStderrDoesNotTake) {
  const int own = dup(STDERR_FILENO), full = open("/dev/full", O_WRONLY | O_CLOEXEC);
  ASSERT_GE(full, 0);
  dup2(full, STDERR_FILENO);
  uint64_t lost = 0;
  {
    ServerLog log(/*calls=*/true);
    log.LogCall(Record());
    log.LogCall(Record());
    // Another thread writes them.
    const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    while ((lost = log.lines_lost()) < 2 && std::chrono::steady_clock::now() < give_up) std::this_thread::yield();
  }
  dup2(own, STDERR_FILENO);
  close(own);
  close(full);
  EXPECT_EQ(lost, 2u);
}

}  // namespace
}  // namespace curvd
