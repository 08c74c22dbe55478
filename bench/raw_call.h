// EstimateCurvature message by message, for what the client library does not tell: when the first result came, and
// what sending alone costs.
#pragma once

#include <grpcpp/completion_queue.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>

#include <memory>
#include <string>

#include "bench/clouds.h"
#include "client/curvature_client.h"

namespace curvd::bench {

// Reads results away without looking into them, so that a server on the same machine is disturbed as little as may be.
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
  // Each waits until it is done. False: the stream has ended.
  bool Wait();
  bool Write(const grpc::Slice& message);
  bool Read();
  grpc::Status Finish();
  // The field that the response is.
  int ResponseField() const;
  [[noreturn]] void Die();

  const curv::CloudView cloud_;
  grpc::CompletionQueue events_;
  grpc::ClientContext context_;
  std::unique_ptr<grpc::GenericClientAsyncReaderWriter> stream_;
  grpc::ByteBuffer response_;
  bool finished_ = false;
};

}  // namespace curvd::bench
