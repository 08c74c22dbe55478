#include "server/observe/server_metrics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <prometheus/collectable.h>
#include <prometheus/metric_family.h>
#include <prometheus/text_serializer.h>

#include <algorithm>
#include <string>

#include "server/rpc/error_detail.h"
#include "server/rpc/error_reasons.h"

namespace curvd {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

std::string Scrape(const ServerMetrics& metrics) {
  std::string text;
  for (const auto& collectable : metrics.collectables()) {
    text += prometheus::TextSerializer().Serialize(collectable->Collect());
  }
  return text;
}

ServerGauges Gauges() {
  ServerGauges gauges;
  gauges.jobs_waiting_for_memory = 1;
  gauges.jobs_waiting_for_workers = 2;
  gauges.workers = 3;
  gauges.workers_busy = 4;
  gauges.memory_reserved_bytes = 5;
  gauges.memory_limit_bytes = 6;
  gauges.streams_open = 7;
  gauges.waiting_limit = 8;
  gauges.streams_limit = 9;
  gauges.log_lines_lost = 10;
  return gauges;
}

TEST(ServerMetricsTest, ReadsTheGaugesAtTheScrape) {
  const ServerMetrics metrics(Gauges);
  const std::string text = Scrape(metrics);
  for (const char* line :
       {"curvd_queue_jobs{queue=\"memory\"} 1\n", "curvd_queue_jobs{queue=\"workers\"} 2\n", "curvd_workers 3\n",
        "curvd_workers_busy 4\n", "curvd_memory_reserved_bytes 5\n", "curvd_memory_limit_bytes 6\n",
        "curvd_streams_open 7\n", "curvd_draining 0\n", "curvd_queue_limit_jobs 8\n", "curvd_streams_limit 9\n",
        "# TYPE curvd_log_lines_lost_total counter\ncurvd_log_lines_lost_total 10\n"}) {
    EXPECT_THAT(text, HasSubstr(line));
  }
}

TEST(ServerMetricsTest, CountsRpcsAsOtherGrpcServersDo) {
  ServerMetrics metrics(Gauges);
  metrics.CountStarted(RpcMethod::kEstimateCurvature);
  metrics.CountReceived(RpcMethod::kEstimateCurvature, 100);
  metrics.CountSent(RpcMethod::kEstimateCurvature, 50);
  metrics.CountHandled(RpcMethod::kEstimateCurvature, absl::StatusCode::kInvalidArgument, 0.2);
  const std::string text = Scrape(metrics);
  const std::string labels =
      R"(grpc_method="EstimateCurvature",grpc_service="curvature.v1.CurvatureService",grpc_type="bidi_stream")";
  for (const std::string& line :
       {"grpc_server_started_total{" + labels + "} 1\n", "grpc_server_msg_received_total{" + labels + "} 1\n",
        "grpc_server_msg_sent_total{" + labels + "} 1\n",
        "grpc_server_handled_total{grpc_code=\"INVALID_ARGUMENT\"," + labels + "} 1\n",
        "grpc_server_handled_total{grpc_code=\"OK\"," + labels + "} 0\n",
        "grpc_server_handling_seconds_count{" + labels + "} 1\n", std::string("curvd_received_bytes_total 100\n"),
        std::string("curvd_sent_bytes_total 50\n")}) {
    EXPECT_THAT(text, HasSubstr(line));
  }
}

TEST(ServerMetricsTest, CountsPointsAndPhasesOfACall) {
  ServerMetrics metrics(Gauges);
  CallRecord record;
  record.points_received = 15;
  record.status_counts[static_cast<size_t>(PointStatus::kOk)] = 10;
  record.status_counts[static_cast<size_t>(PointStatus::kDegenerateArea)] = 2;
  record.status_counts[static_cast<size_t>(PointStatus::kOutlier)] = 3;
  record.seconds.admit = 0.0;
  record.seconds.estimate = 3.0;
  metrics.CountCall(record);
  const std::string text = Scrape(metrics);
  EXPECT_THAT(text, HasSubstr("curvd_points_total{status=\"ok\"} 10\n"));
  EXPECT_THAT(text, HasSubstr("curvd_points_total{status=\"degenerate_area\"} 2\n"));
  EXPECT_THAT(text, HasSubstr("curvd_points_total{status=\"outlier\"} 3\n"));
  EXPECT_THAT(text, HasSubstr("curvd_cloud_points_bucket{le=\"100\"} 1\n"));
  EXPECT_THAT(text, HasSubstr("curvd_cloud_points_sum 15\n"));
  EXPECT_THAT(text, HasSubstr("curvd_phase_seconds_sum{phase=\"estimate\"} 3\n"));
  EXPECT_THAT(text, HasSubstr("curvd_phase_seconds_count{phase=\"admit\"} 1\n"));
}

TEST(ServerMetricsTest, CountsThePhasesThatAFailedCallCameTo) {
  ServerMetrics metrics(Gauges);
  CallRecord record;
  record.status = absl::DeadlineExceededError("gone");
  record.points_received = 12;
  record.seconds.receive = 0.5;
  record.seconds.admit = 40.0;
  metrics.CountCall(record);
  const std::string text = Scrape(metrics);
  EXPECT_THAT(text, HasSubstr("curvd_phase_seconds_sum{phase=\"admit\"} 40\n"));
  EXPECT_THAT(text, HasSubstr("curvd_phase_seconds_count{phase=\"receive\"} 1\n"));
  EXPECT_THAT(text, HasSubstr("curvd_phase_seconds_count{phase=\"queue\"} 0\n"));
  EXPECT_THAT(text, HasSubstr("curvd_cloud_points_count 0\n"));
}

TEST(ServerMetricsTest, CountsFailuresByKnownReasonsOnly) {
  ServerMetrics metrics(Gauges);
  CallRecord record;
  record.status = MakeError(absl::StatusCode::kInvalidArgument, {kReasonChunkLength, "f", "v", "l", {}});
  metrics.CountCall(record);
  record.status = MakeError(absl::StatusCode::kUnknown, {"MADE_UP", "f", "v", "l", {}});
  metrics.CountCall(record);
  const std::string text = Scrape(metrics);
  EXPECT_THAT(text, HasSubstr("curvd_failures_total{reason=\"CHUNK_LENGTH\"} 1\n"));
  EXPECT_THAT(text, HasSubstr("curvd_failures_total{reason=\"INTERNAL\"} 1\n"));
  EXPECT_THAT(text, HasSubstr("curvd_failures_total{reason=\"DRAINING\"} 0\n"));
  EXPECT_THAT(text, Not(HasSubstr("MADE_UP")));
}

TEST(ServerMetricsTest, TellsNothingThatACallerChose) {
  ServerMetrics metrics(Gauges);
  const std::string before = Scrape(metrics);
  CallRecord record;
  record.request_id = record.peer = record.request_tag = "secret";
  record.status = MakeError(absl::StatusCode::kInvalidArgument, {kReasonInvalidOption, "f", "secret", "l", {}});
  metrics.CountCall(record);
  const std::string after = Scrape(metrics);
  EXPECT_THAT(after, Not(HasSubstr("secret")));
  EXPECT_EQ(std::count(before.begin(), before.end(), '\n'), std::count(after.begin(), after.end(), '\n'));
}

TEST(ServerMetricsTest, TellsWhatRuns) {
  const ServerMetrics metrics(Gauges);
  EXPECT_THAT(Scrape(metrics), HasSubstr("curvd_build_info{cpu_kind="));
}

}  // namespace
}  // namespace curvd
