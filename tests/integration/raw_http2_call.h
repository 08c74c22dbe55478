// One EstimateCurvature call written as HTTP/2 frames, for streams that no gRPC library would send.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "curvature/v1/curvature.pb.h"

namespace curvd {

// How a raw call ended.
struct RawHttp2Result {
  std::string grpc_status;  // of the trailers, as a number: "0" for OK
  std::vector<curvature::v1::EstimateCurvatureResponse> responses;
};

// A connection of its own with one stream. Breaks of HTTP/2 by the server are test failures. Not thread-safe.
class RawHttp2Call {
 public:
  // Connects to a port of this machine, and sends the headers of the call. The server may send `window` bytes of
  // messages.
  explicit RawHttp2Call(int port, uint32_t window = 65'535);
  ~RawHttp2Call();
  RawHttp2Call(const RawHttp2Call&) = delete;
  RawHttp2Call& operator=(const RawHttp2Call&) = delete;

  // `bytes` of the stream of length-prefixed messages, in one DATA frame.
  void SendBytes(const std::string& bytes, bool end_stream = false);
  // Half-closes with trailers, which gRPC's clients never send.
  void SendTrailers();
  // Reads until the server has ended the stream.
  RawHttp2Result Finish();

  // `message` as gRPC frames it: five bytes, then the message.
  static std::string Framed(const curvature::v1::EstimateCurvatureRequest& message);

 private:
  void SendFrame(char type, char flags, int stream, const std::string& payload);
  std::string Receive(size_t size);

  int fd_;
};

}  // namespace curvd
