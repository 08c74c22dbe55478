#include "server/observe/stranger_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <prometheus/collectable.h>
#include <prometheus/metric_family.h>

#include <algorithm>
#include <map>
#include <memory>
#include <string>

namespace curvd {
namespace {

using ::testing::HasSubstr;

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
  StrangerLogTest() { ::testing::internal::CaptureStderr(); }
  // What was logged. Nothing may be noted afterwards.
  std::string Logged() {
    log_.reset();  // writes what is left
    return ::testing::internal::GetCapturedStderr();
  }

  SecurityMetrics metrics_;
  std::unique_ptr<ServerLog> log_ = std::make_unique<ServerLog>(false);
  StrangerLog strangers_{metrics_, *log_};
};

TEST_F(StrangerLogTest, TellsAddressAgeBytesAndWhy) {
  strangers_.Note({StrangerReason::kNoCall, "ipv4:10.0.0.7:1", 0.25, 517});
  strangers_.Note({StrangerReason::kNoDescriptor, "", {}, {}});
  EXPECT_EQ(Strangers(metrics_)["no_call"], 1);
  EXPECT_EQ(Strangers(metrics_)["no_descriptor"], 1);
  const std::string text = Logged();
  EXPECT_THAT(text, HasSubstr("\"event\":\"stranger\",\"reason\":\"no_call\",\"peer\":\"ipv4:10.0.0.7:1\","
                              "\"seconds\":0.25,\"received_bytes\":517,\"message\":\""));
  EXPECT_THAT(text, HasSubstr("\"reason\":\"no_descriptor\",\"message\":\""));
}

TEST_F(StrangerLogTest, CountsAllButLogsAFewASecond) {
  for (int i = 0; i < 1'000; ++i) strangers_.Note({StrangerReason::kConnectionLimit, "ipv4:10.0.0.7:1", {}, {}});
  EXPECT_EQ(Strangers(metrics_)["connection_limit"], 1'000);
  const std::string text = Logged();
  EXPECT_THAT(text, HasSubstr("\"reason\":\"connection_limit\""));
  // 20 a second, on a machine that takes less than ten seconds for a thousand.
  EXPECT_LE(std::count(text.begin(), text.end(), '\n'), 200);
}

TEST_F(StrangerLogTest, CountsThoseThatSentNothingWithoutALine) {
  strangers_.Note({StrangerReason::kNothingSent, "ipv4:10.0.0.7:1", 0.25, 1});
  EXPECT_EQ(Strangers(metrics_)["nothing_sent"], 1);
  EXPECT_EQ(Logged(), "");
}

}  // namespace
}  // namespace curvd
