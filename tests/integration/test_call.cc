#include "tests/integration/test_call.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;

float FloatAt(const std::string& bytes, size_t i) {
  float value = 0.0f;
  EXPECT_LE((i + 1) * sizeof(float), bytes.size());
  std::memcpy(&value, bytes.data() + i * sizeof(float), sizeof(float));
  return value;
}

void ReadDetails(CallResult& result) {
  if (result.status.error_details().empty()) return;
  google::rpc::Status details;
  ASSERT_TRUE(details.ParseFromString(result.status.error_details()));
  EXPECT_EQ(details.code(), static_cast<int>(result.status.error_code()));
  EXPECT_EQ(details.message(), result.status.error_message());
  for (const google::protobuf::Any& detail : details.details()) {
    google::rpc::ErrorInfo info;
    google::rpc::RetryInfo retry;
    if (detail.UnpackTo(&info)) {
      EXPECT_EQ(info.domain(), "curvd");
      result.reason = info.reason();
      result.metadata.insert(info.metadata().begin(), info.metadata().end());
    } else if (detail.UnpackTo(&retry)) {
      result.retry_seconds = static_cast<double>(retry.retry_delay().seconds()) + 1e-9 * retry.retry_delay().nanos();
    }
  }
}

}  // namespace

float CallResult::Mean(size_t i) const { return FloatAt(mean, i); }
float CallResult::K1(size_t i) const { return FloatAt(k1, i); }
float CallResult::K2(size_t i) const { return FloatAt(k2, i); }

std::array<float, 3> CallResult::Normal(size_t i) const {
  return {FloatAt(normal, 3 * i), FloatAt(normal, 3 * i + 1), FloatAt(normal, 3 * i + 2)};
}

std::string CallResult::AllBytes() const {
  return point_status + mean + gaussian + k1 + k2 + d1 + d2 + radius + normal + normal_residual + normal_variance_ratio;
}

TestCall::TestCall(const std::shared_ptr<grpc::Channel>& channel, std::optional<std::chrono::milliseconds> timeout,
                   grpc_compression_algorithm compression,
                   const std::vector<std::pair<std::string, std::string>>& metadata)
    : stub_(v1::CurvatureService::NewStub(channel)) {
  if (timeout.has_value()) context_.set_deadline(std::chrono::system_clock::now() + *timeout);
  context_.set_compression_algorithm(compression);
  for (const auto& [key, value] : metadata) context_.AddMetadata(key, value);
  stream_ = stub_->EstimateCurvature(&context_);
}

TestCall::~TestCall() {
  if (finished_) return;
  Cancel();
  Finish();
}

bool TestCall::Send(const Request& message) { return stream_->Write(message); }

bool TestCall::SendHeader(const v1::CloudHeader& header) {
  Request message;
  *message.mutable_header() = header;
  return Send(message);
}

bool TestCall::SendPoints(const TestCloud& cloud, size_t first, size_t count) {
  Request message;
  message.mutable_chunk()->set_first_index(first);
  message.mutable_chunk()->set_positions(cloud.PackedPositions(first, count));
  message.mutable_chunk()->set_normals(cloud.PackedNormals(first, count));
  message.mutable_chunk()->set_viewpoints(cloud.PackedViewpoints(first, count));
  return Send(message);
}

bool TestCall::SendCloud(const TestCloud& cloud, size_t chunk_points) {
  for (size_t first = 0; first < cloud.size(); first += chunk_points) {
    if (!SendPoints(cloud, first, std::min(chunk_points, cloud.size() - first))) return false;
  }
  return true;
}

void TestCall::HalfClose() {
  if (!std::exchange(half_closed_, true)) stream_->WritesDone();
}

std::optional<TestCall::Response> TestCall::ReadAny() {
  Response message;
  if (!stream_->Read(&message)) return std::nullopt;
  if (message.has_accepted()) request_id_ = message.accepted().request_id();
  return message;
}

std::optional<TestCall::Response> TestCall::Read() {
  for (;;) {
    std::optional<Response> message = ReadAny();
    if (!message.has_value() || !message->has_progress()) return message;
  }
}

v1::Accepted TestCall::ReadAccepted() {
  const std::optional<Response> message = ReadAny();
  if (message.has_value() && message->has_accepted()) return message->accepted();
  ADD_FAILURE() << "the first message is no Accepted";
  return {};
}

void TestCall::Take(const Response& message, CallResult& result) {
  EXPECT_FALSE(result.summary.has_value()) << "a message after the summary";
  if (message.has_summary()) result.summary = message.summary();
  if (!message.has_result()) return;
  EXPECT_TRUE(half_closed_) << "a result before the half-close";
  const v1::ResultChunk& chunk = message.result();
  EXPECT_EQ(chunk.first_index(), result.size()) << "a gap or disorder";
  EXPECT_GT(chunk.point_count(), 0u);
  EXPECT_EQ(chunk.status().size(), chunk.point_count());
  EXPECT_LT(chunk.ByteSizeLong(), 4u << 20);
  result.point_status += chunk.status();
  result.mean += chunk.mean_curvature();
  result.gaussian += chunk.gaussian_curvature();
  result.k1 += chunk.k1();
  result.k2 += chunk.k2();
  result.d1 += chunk.d1();
  result.d2 += chunk.d2();
  result.radius += chunk.radius();
  result.normal += chunk.normal();
  result.normal_residual += chunk.normal_residual();
  result.normal_variance_ratio += chunk.normal_variance_ratio();
}

CallResult TestCall::Finish() {
  CallResult result;
  while (const std::optional<Response> message = ReadAny()) Take(*message, result);
  HalfClose();
  finished_ = true;
  result.status = stream_->Finish();
  result.request_id = request_id_;
  ReadDetails(result);
  return result;
}

v1::CloudHeader HeaderFor(const TestCloud& cloud, uint32_t neighbor_count) {
  v1::CloudHeader header;
  header.set_point_count(cloud.size());
  if (neighbor_count != 0) header.mutable_options()->set_neighbor_count(neighbor_count);
  return header;
}

CallResult Estimate(const std::shared_ptr<grpc::Channel>& channel, const v1::CloudHeader& header,
                    const TestCloud& cloud, size_t chunk_points) {
  TestCall call(channel);
  if (call.SendHeader(header) && call.SendCloud(cloud, chunk_points)) call.HalfClose();
  return call.Finish();
}

::testing::AssertionResult FailedWith(const CallResult& result, grpc::StatusCode code, const std::string& reason,
                                      const std::vector<std::string>& words) {
  const std::string& message = result.status.error_message();
  if (result.status.error_code() != code || result.reason != reason) {
    return ::testing::AssertionFailure() << "code " << result.status.error_code() << ", reason \"" << result.reason
                                         << "\": " << message;
  }
  std::vector<std::string> wanted = words;
  if (result.metadata.count("request_id") == 0) return ::testing::AssertionFailure() << "no request id in the details";
  wanted.push_back(result.metadata.at("request_id"));
  for (const std::string& word : wanted) {
    if (message.find(word) == std::string::npos) {
      return ::testing::AssertionFailure() << '"' << message << "\" does not name " << word;
    }
  }
  if (result.summary.has_value()) return ::testing::AssertionFailure() << "a summary in a call that failed";
  return ::testing::AssertionSuccess();
}

::testing::AssertionResult Succeeded(const CallResult& result, size_t points) {
  if (!result.status.ok()) return ::testing::AssertionFailure() << result.status.error_message();
  if (!result.summary.has_value()) return ::testing::AssertionFailure() << "OK without a summary";
  const v1::StatusCounts& counts = result.summary->status_counts();
  const uint64_t counted = counts.ok() + counts.too_few_neighbors() + counts.degenerate_area() +
                           counts.invalid_input() + counts.inconsistent_normals() + counts.singular_fit() +
                           counts.opposed_normals() + counts.outlier();
  if (result.summary->point_count() != points || result.size() != points || counted != points) {
    return ::testing::AssertionFailure() << result.summary->point_count() << " points in the summary, " << counted
                                         << " in its counts, " << result.size() << " results for " << points;
  }
  return ::testing::AssertionSuccess();
}

double MeanOfMeans(const CallResult& result) {
  double sum = 0.0;
  size_t count = 0;
  for (size_t i = 0; i < result.size(); ++i) {
    if (result.point_status[i] != kPointOk) continue;
    sum += result.Mean(i);
    ++count;
  }
  return sum / static_cast<double>(count);
}

}  // namespace curvd
