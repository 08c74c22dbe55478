// Plays any sequence of messages of a hostile server to the C++ client. The first byte is the cloud's size; then each
// step is an opcode and its operands: raw bytes as a message, the next chunk of results, or the end with a status.
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <string>

#include "client/result_collector.h"
#include "client/rpc_error.h"
#include "curvature/v1/curvature.pb.h"
#include "tests/byte_buffers.h"
#include "tests/fuzz/input.h"
#include "tests/fuzz/require.h"

namespace {

namespace v1 = curvature::v1;

// A chunk of results whose index is right; its arrays are as long as the input allows.
v1::ResultChunk NextResults(uint64_t first, fuzz::Input& input) {
  const uint32_t count = input.Byte() % 32;
  v1::ResultChunk chunk;
  chunk.set_first_index(first);
  chunk.set_point_count(count);
  chunk.set_status(std::string(input.Bytes(count)));
  for (std::string* scalars : {chunk.mutable_mean_curvature(), chunk.mutable_gaussian_curvature(), chunk.mutable_k1(),
                               chunk.mutable_k2(), chunk.mutable_radius()}) {
    scalars->assign(input.Bytes(size_t{count} * 4));
  }
  for (std::string* vectors : {chunk.mutable_d1(), chunk.mutable_d2()}) {
    vectors->assign(input.Bytes(size_t{count} * 12));
  }
  return chunk;
}

void CheckResult(const curv::CurvatureResult& result, size_t points) {
  for (const auto* scalars : {&result.mean, &result.gaussian, &result.k1, &result.k2, &result.radius}) {
    fuzz::Require(scalars->size() == points, "a whole result has a scalar of each kind for each point");
  }
  for (const auto* vectors : {&result.d1, &result.d2}) {
    fuzz::Require(vectors->size() == 3 * points, "a whole result has directions for each point");
  }
  fuzz::Require(result.status.size() == points, "a whole result has a status for each point");
  uint64_t counted = 0;
  for (const uint64_t count : result.summary.status_counts) counted += count;
  fuzz::Require(counted == points, "the status counts add up");
}

// The end with an error: code, message and details are the server's.
void CheckStatus(fuzz::Input& input) {
  // Codes that nobody has given a meaning come over the wire as they are.
  const auto code = static_cast<grpc::StatusCode>(input.Byte() % 32);
  const std::string message(input.Block());
  const grpc::Status status(code, message, std::string(input.Rest()));
  const absl::Status arrived = curv::ToAbslStatus(status);
  fuzz::Require(arrived.ok() == status.ok(), "an error stays an error");
  if (status.ok()) return;
  for (const char c : arrived.message())
    fuzz::Require(!std::iscntrl(static_cast<unsigned char>(c)), "messages hold no control characters");
  const auto delay = curv::RetryDelay(status);
  fuzz::Require(!delay || *delay >= absl::ZeroDuration(), "delays are not negative");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  fuzz::Input input(bytes, size);
  const uint8_t points = input.Byte();
  curv::ResultCollector collector(points);
  while (!input.empty()) {
    const int opcode = input.Byte() % 3;
    if (opcode == 2) {
      CheckStatus(input);
      return 0;
    }
    std::string bytes;
    if (opcode == 1) {
      v1::EstimateCurvatureResponse response;
      *response.mutable_result() = NextResults(collector.points_received(), input);
      bytes = response.SerializeAsString();
    } else {
      bytes = input.Block();
    }
    constexpr size_t kPieceBytes = 37;
    grpc::ByteBuffer message = curvd::ToByteBuffer(bytes, kPieceBytes);
    if (const absl::Status status = collector.Take(message); !status.ok()) {
      fuzz::Require(absl::IsInternal(status), "a broken protocol is INTERNAL");
      return 0;
    }
    fuzz::Require(collector.points_received() <= points, "no more results than points");
  }
  if (collector.Finish().ok()) CheckResult(collector.Release(), points);
  return 0;
}
