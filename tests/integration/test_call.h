// One EstimateCurvature call as a careful client makes it, every promise of the protocol checked on the way.
#pragma once

#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "curvature/v1/curvature.grpc.pb.h"
#include "tests/integration/clouds.h"

namespace curvd {

// What the server sent after the half-close.
struct CallResult {
  grpc::Status status;
  // Of the error details.
  std::string reason;
  std::map<std::string, std::string> metadata;
  std::optional<double> retry_seconds;

  std::string request_id;
  std::optional<curvature::v1::Summary> summary;
  // All chunks one behind the other.
  std::string point_status;
  std::string mean, gaussian, k1, k2, d1, d2, radius;
  std::string normal, normal_residual, normal_variance_ratio;

  size_t size() const { return point_status.size(); }
  float Mean(size_t i) const;
  float K1(size_t i) const;
  float K2(size_t i) const;
  std::array<float, 3> Normal(size_t i) const;
  // Everything that was sent, as one string to compare.
  std::string AllBytes() const;
};

// A call that is open. Breaks of the protocol are test failures. Not thread-safe.
class TestCall {
 public:
  using Request = curvature::v1::EstimateCurvatureRequest;
  using Response = curvature::v1::EstimateCurvatureResponse;

  explicit TestCall(const std::shared_ptr<grpc::Channel>& channel,
                    std::optional<std::chrono::milliseconds> timeout = std::nullopt,
                    grpc_compression_algorithm compression = GRPC_COMPRESS_NONE,
                    const std::vector<std::pair<std::string, std::string>>& metadata = {});
  ~TestCall();

  // Each returns false once the server has ended the call.
  bool Send(const Request& message);
  bool SendHeader(const curvature::v1::CloudHeader& header);
  bool SendPoints(const TestCloud& cloud, size_t first, size_t count);
  bool SendCloud(const TestCloud& cloud, size_t chunk_points = 65'536);
  void HalfClose();

  // The next message that is no Progress; nullopt at the end of the call.
  std::optional<Response> Read();
  // The next message, Progress included.
  std::optional<Response> ReadAny();
  // Reads the Accepted, or fails the test.
  curvature::v1::Accepted ReadAccepted();
  // Reads to the end.
  CallResult Finish();
  void Cancel() { context_.TryCancel(); }

 private:
  void Take(const Response& message, CallResult& result);

  std::unique_ptr<curvature::v1::CurvatureService::Stub> stub_;
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<Request, Response>> stream_;
  bool half_closed_ = false;
  bool finished_ = false;
  std::string request_id_;
};

// As CallResult::point_status has it.
inline constexpr char kPointOk = static_cast<char>(curvature::v1::POINT_STATUS_OK);

// The mean of the mean curvatures, of points that were estimated.
double MeanOfMeans(const CallResult& result);

// A header with the cloud's size, and K if it is not 0.
curvature::v1::CloudHeader HeaderFor(const TestCloud& cloud, uint32_t neighbor_count = 0);

// A whole call.
CallResult Estimate(const std::shared_ptr<grpc::Channel>& channel, const curvature::v1::CloudHeader& header,
                    const TestCloud& cloud, size_t chunk_points = 65'536);

// Whether the call failed with `code` and `reason`, its message names all of `words` and the request id, and its
// details agree with it.
::testing::AssertionResult FailedWith(const CallResult& result, grpc::StatusCode code, const std::string& reason,
                                      const std::vector<std::string>& words);

// Whether the call ended with OK, a summary and a result for each of `points` points.
::testing::AssertionResult Succeeded(const CallResult& result, size_t points);

}  // namespace curvd
