// EstimateCurvature message by message, for what the client library does not tell: when the first result came, and
// what receiving alone costs.
#pragma once

#include <memory>
#include <string>

#include "bench/clouds.h"
#include "curvature/v1/curvature.grpc.pb.h"

namespace curvd::bench {

// Ends the program if the server answers with an error. Not thread-safe.
class RawCall {
 public:
  RawCall(const std::string& address, const BenchCloud& cloud, uint32_t k);
  ~RawCall();  // cancels what is not finished

  // Sends all points, without ending the cloud. Returns once gRPC has taken the last of them.
  void SendPoints();

  // Wall-clock seconds from the end of the cloud.
  struct Waits {
    double first_result = 0.0;
    double summary = 0.0;
  };
  // Ends the cloud and reads all results.
  Waits FinishAndRead();

 private:
  const BenchCloud& cloud_;
  std::unique_ptr<curvature::v1::CurvatureService::Stub> stub_;
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriterInterface<curvature::v1::EstimateCurvatureRequest,
                                                    curvature::v1::EstimateCurvatureResponse>>
      stream_;
  bool finished_ = false;
};

}  // namespace curvd::bench
