#include "server/observe/stranger_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <prometheus/collectable.h>
#include <prometheus/metric_family.h>

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <utility>

namespace curvd {
namespace {

// curvd_strangers_total by reason.
std::map<std::string, double> Strangers(const SecurityMetrics& metrics) {
  std::map<std::string, double> counts;
  for (const auto& collectable : metrics.collectables()) {
    for (const prometheus::MetricFamily& family : collectable->Collect()) {
      if (family.name != "curvd_strangers_total") continue;
      for (const prometheus::ClientMetric& metric : family.metric) {
        counts[metric.label.front().value] = metric.counter.value;
      }
    }
  }
  return counts;
}

class StrangerLogTest : public ::testing::Test {
 protected:
  SecurityMetrics metrics_;
  std::unique_ptr<ServerLog> log_ = std::make_unique<ServerLog>(false);
  StrangerLog strangers_{metrics_, *log_};
};

TEST_F(StrangerLogTest, UnderstandsWhatGrpcSaysOfHandshakes) {
  const std::pair<const char*, const char*> lines[] = {
      {"Handshaking failed: UNKNOWN:Ssl handshake failed: error:0A0000C7:SSL routines::peer did not return a "
       "certificate",
       "no_certificate"},
      {"Handshaking failed: error:0A000086:SSL routines::certificate verify failed", "bad_certificate"},
      {"Handshaking failed: error:0A00010B:SSL routines::wrong version number", "plain_text"},
      {"Handshaking failed: UNKNOWN:Handshake read failed {children:[UNKNOWN:Handshake timed out {}]}",
       "handshake_timeout"},
      {"Handshaking failed: whatever comes", "handshake_failed"},
      {"received initial metadata size exceeds limit (10554 vs. 8192)", "header_too_large"},
  };
  for (const auto& [line, reason] : lines) {
    const double before = Strangers(metrics_)[reason];
    strangers_.NoteGrpcLine("chttp2_server.cc", line, false);
    EXPECT_EQ(Strangers(metrics_)[reason], before + 1) << line;
  }
}

TEST_F(StrangerLogTest, NamesThePeerOfAFailedHandshakeWhereItIsKnown) {
  ::testing::internal::CaptureStderr();
  strangers_.NoteGrpcLine("", "Handshaking failed: Ssl handshake failed: before anybody can tell", false);
  strangers_.FindPeersWith([] { return std::string("ipv4:10.0.0.7:1"); });
  strangers_.NoteGrpcLine("", "Handshaking failed: Ssl handshake failed: wrong version number", false);
  strangers_.NoteGrpcLine("",
                          "Handshaking failed: UNKNOWN:Handshake read failed {children:[INTERNAL:Socket closed "
                          "{target_address:\"ipv6:%5B::1%5D:46132\", grpc_status:14, fd:6}]}",
                          false);
  strangers_.FindPeersWith(nullptr);
  log_.reset();  // writes what is left
  const std::string text = ::testing::internal::GetCapturedStderr();
  EXPECT_THAT(text, ::testing::HasSubstr("\"reason\":\"plain_text\",\"peer\":\"ipv4:10.0.0.7:1\""));
  EXPECT_THAT(text, ::testing::HasSubstr("\"peer\":\"ipv6:%5B::1%5D:46132\""));
  EXPECT_THAT(text.substr(0, text.find('\n')), ::testing::Not(::testing::HasSubstr("peer")));
}

TEST_F(StrangerLogTest, LeavesOtherLinesUncounted) {
  strangers_.NoteGrpcLine("ssl_security_connector.cc", "Using new server certificate config", false);
  strangers_.NoteGrpcLine("ssl_transport_security.cc", "Handshake failed with fatal error", true);
  for (const auto& [reason, count] : Strangers(metrics_)) EXPECT_EQ(count, 0) << reason;
}

TEST_F(StrangerLogTest, CountsAllButLogsAFewASecond) {
  ::testing::internal::CaptureStderr();
  for (int i = 0; i < 1'000; ++i) strangers_.NoteRefused(StrangerReason::kConnectionLimit, "ipv4:10.0.0.7:1");
  log_.reset();  // writes what is left
  const std::string text = ::testing::internal::GetCapturedStderr();
  EXPECT_EQ(Strangers(metrics_)["connection_limit"], 1'000);
  EXPECT_THAT(text, ::testing::HasSubstr("\"reason\":\"connection_limit\",\"peer\":\"ipv4:10.0.0.7:1\""));
  // 20 a second, on a machine that takes less than ten seconds for a thousand.
  EXPECT_LE(std::count(text.begin(), text.end(), '\n'), 200);
}

}  // namespace
}  // namespace curvd
