#include "bench/raw_call.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "bench/stopwatch.h"
#include "client/request_encoder.h"
#include "curvature/v1/curvature.pb.h"

namespace curvd::bench {
namespace {

using Response = curvature::v1::EstimateCurvatureResponse;

constexpr size_t kChunkPoints = (1 << 20) / 24;  // 1 MiB of arrays

// gRPC keeps its address.
const std::string& Method() {
  static const std::string& method = *new std::string("/curvature.v1.CurvatureService/EstimateCurvature");
  return method;
}

}  // namespace

RawCall::RawCall(const std::string& address, const BenchCloud& cloud, uint32_t k)
    : cloud_(cloud.positions, cloud.normals) {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(-1);
  arguments.SetInt(GRPC_ARG_HTTP2_STREAM_LOOKAHEAD_BYTES, 4 << 20);
  const auto channel = grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
  stream_ = grpc::GenericStub(channel).PrepareCall(&context_, Method(), &events_);
  stream_->StartCall(this);
  curv::EstimateOptions options;
  options.neighbor_count = k;
  if (!Wait() || !Write(curv::PackHeader(cloud_, options)) || !Read() ||
      ResponseField() != Response::kAcceptedFieldNumber) {
    Die();
  }
}

RawCall::~RawCall() {
  if (!finished_) {
    context_.TryCancel();
    while (Read()) {
    }
    Finish();
  }
  events_.Shutdown();
  Wait();
}

bool RawCall::Wait() {
  void* tag = nullptr;
  bool ok = false;
  return events_.Next(&tag, &ok) && ok;
}

bool RawCall::Write(const grpc::Slice& message) {
  stream_->Write(grpc::ByteBuffer(&message, 1), this);
  return Wait();
}

bool RawCall::Read() {
  response_.Clear();
  stream_->Read(&response_, this);
  return Wait();
}

grpc::Status RawCall::Finish() {
  grpc::Status status;
  stream_->Finish(&status, this);
  Wait();
  finished_ = true;
  return status;
}

// A message of one field begins with its tag, whose lowest bits are the wire type.
int RawCall::ResponseField() const {
  std::vector<grpc::Slice> slices;
  const bool has_bytes = response_.Dump(&slices).ok() && !slices.empty() && slices.front().size() > 0;
  return has_bytes ? *slices.front().begin() >> 3 : 0;
}

void RawCall::Die() {
  const grpc::Status status = Finish();
  std::fprintf(stderr, "the call failed: %s\n", status.error_message().c_str());
  std::exit(1);
}

void RawCall::SendPoints() {
  for (size_t first = 0; first < cloud_.size(); first += kChunkPoints) {
    if (!Write(curv::PackChunk(cloud_, first, std::min(kChunkPoints, cloud_.size() - first)))) Die();
  }
}

RawCall::Waits RawCall::FinishAndRead() {
  const double end = WallSeconds();
  stream_->WritesDone(this);
  Wait();
  Waits waits;
  while (Read()) {
    const int field = ResponseField();
    if (field == Response::kResultFieldNumber && waits.first_result == 0.0) waits.first_result = WallSeconds() - end;
    if (field == Response::kSummaryFieldNumber) waits.summary = WallSeconds() - end;
  }
  if (waits.summary == 0.0 || !Finish().ok()) Die();
  return waits;
}

}  // namespace curvd::bench
