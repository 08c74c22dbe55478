#include "bench/raw_call.h"

#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "bench/stopwatch.h"

namespace curvd::bench {
namespace {

namespace v1 = curvature::v1;

constexpr size_t kChunkPoints = (1 << 20) / 24;  // 1 MiB of arrays

void Die(const grpc::Status& status) {
  std::fprintf(stderr, "the call failed: %s\n", status.error_message().c_str());
  std::exit(1);
}

}  // namespace

RawCall::RawCall(const std::string& address, const BenchCloud& cloud, uint32_t k) : cloud_(cloud) {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(-1);
  arguments.SetInt(GRPC_ARG_HTTP2_STREAM_LOOKAHEAD_BYTES, 4 << 20);
  stub_ =
      v1::CurvatureService::NewStub(grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments));
  stream_ = stub_->EstimateCurvature(&context_);
  v1::EstimateCurvatureRequest request;
  v1::CloudHeader& header = *request.mutable_header();
  header.set_point_count(cloud.size());
  header.set_scalar_type(v1::SCALAR_TYPE_FLOAT32);
  header.mutable_options()->set_neighbor_count(k);
  v1::EstimateCurvatureResponse response;
  if (!stream_->Write(request) || !stream_->Read(&response) || !response.has_accepted()) Die(stream_->Finish());
}

RawCall::~RawCall() {
  if (finished_) return;
  context_.TryCancel();
  v1::EstimateCurvatureResponse response;
  while (stream_->Read(&response)) {
  }
  stream_->Finish();
}

void RawCall::SendPoints() {
  v1::EstimateCurvatureRequest request;
  for (size_t first = 0; first < cloud_.size(); first += kChunkPoints) {
    const size_t count = std::min(kChunkPoints, cloud_.size() - first);
    v1::PointChunk& chunk = *request.mutable_chunk();
    chunk.set_first_index(first);
    chunk.set_positions(cloud_.positions.data() + 3 * first, 3 * count * sizeof(float));
    chunk.set_normals(cloud_.normals.data() + 3 * first, 3 * count * sizeof(float));
    if (!stream_->Write(request)) Die(stream_->Finish());
  }
}

RawCall::Waits RawCall::FinishAndRead() {
  const double end = WallSeconds();
  stream_->WritesDone();
  Waits waits;
  bool summarized = false;
  v1::EstimateCurvatureResponse response;
  while (stream_->Read(&response)) {
    if (response.has_result() && waits.first_result == 0.0) waits.first_result = WallSeconds() - end;
    if (response.has_summary()) {
      waits.summary = WallSeconds() - end;
      summarized = true;
    }
  }
  const grpc::Status status = stream_->Finish();
  if (!status.ok() || !summarized) Die(status);
  finished_ = true;
  return waits;
}

}  // namespace curvd::bench
