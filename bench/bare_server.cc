// The least server around the same core: gRPC's synchronous API and messages as protobuf fills them; no admission, no
// limits but the core's, no fairness, no metrics, no log, no access control, no keepalive, no drain. What curvd costs
// beyond it is the price of being trusted.
//
//   bare_server THREADS    serves on a free loopback port, which it tells in the words of curvd's log
#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "core/job/estimation_job.h"
#include "core/job/field_arrays.h"
#include "core/job/worker_pool.h"
#include "curvature/v1/curvature.grpc.pb.h"
#include "proto/result_columns.h"
#include "server/call/header_options.h"
#include "server/call/result_encoder.h"
#include "server/call/summary_message.h"
#include "server/host/memory_reuse.h"

namespace curvd::bench {
namespace {

namespace v1 = curvature::v1;

constexpr CallLimits kLimits{.max_points = 1u << 30,
                             .max_chunk_bytes = 4 << 20,
                             .max_neighbor_count = 10'000,
                             .memory_bytes = uint64_t{1} << 40,
                             .max_streams = 1'000};

void FillResults(const PageArray<PointCurvature>& points, size_t first, size_t count, const QuantitySet& quantities,
                 v1::ResultChunk* chunk) {
  chunk->set_first_index(first);
  chunk->set_point_count(static_cast<uint32_t>(count));
  const auto& columns = curvature::wire::ResultColumns();
  std::vector<std::string> arrays(columns.size());
  ColumnPlaces places{};
  for (size_t i = 0; i < columns.size(); ++i) {
    if (columns[i].quantity != v1::QUANTITY_UNSPECIFIED && !quantities.Has(columns[i].quantity)) continue;
    arrays[i].resize(count * columns[i].bytes_per_point);
    places[ColumnIndex(columns[i].name)] = arrays[i].data();
  }
  SplitField(points.span().subspan(first, count), places);
  for (size_t i = 0; i < columns.size(); ++i) {
    const auto* field = v1::ResultChunk::descriptor()->FindFieldByNumber(columns[i].field);
    chunk->GetReflection()->SetString(chunk, field, std::move(arrays[i]));
  }
}

grpc::Status Failure(const absl::Status& status) {
  return {static_cast<grpc::StatusCode>(status.code()), std::string(status.message())};
}

class BareService final : public v1::CurvatureService::Service {
 public:
  using Stream = grpc::ServerReaderWriter<v1::EstimateCurvatureResponse, v1::EstimateCurvatureRequest>;

  explicit BareService(int threads) : pool_(threads) {}

  grpc::Status EstimateCurvature(grpc::ServerContext*, Stream* stream) override {
    v1::EstimateCurvatureRequest request;
    v1::EstimateCurvatureResponse response;
    stream->Read(&request);
    const absl::StatusOr<CallOptions> options = ResolveHeader(request.header(), kLimits);
    if (!options.ok()) return Failure(options.status());
    FillAccepted(*options, kLimits, "bare", response.mutable_accepted());
    stream->Write(response);
    Cloud cloud(options->scalar_type, options->invalid_point_policy);
    while (stream->Read(&request)) {
      const absl::Status appended = cloud.Append(request.chunk().positions(), request.chunk().normals());
      if (!appended.ok()) return Failure(appended);
    }
    if (const absl::Status finished = cloud.Finish(); !finished.ok()) return Failure(finished);
    auto result = curvd::EstimateCurvature(std::move(cloud), options->estimator, pool_);
    if (!result.ok()) return Failure(result.status());
    const auto& points = result->field.points;
    for (size_t first = 0; first < points.size(); first += kResultChunkPoints) {
      const size_t count = std::min(kResultChunkPoints, points.size() - first);
      FillResults(points, first, count, options->quantities, response.mutable_result());
      if (!stream->Write(response)) return grpc::Status::CANCELLED;
    }
    CallRecord record;
    record.points_received = points.size();
    record.status_counts = result->field.status_counts;
    FillSummary(record, response.mutable_summary());
    stream->Write(response);
    return grpc::Status::OK;
  }

 private:
  WorkerPool pool_;
};

int Serve(int threads) {
  ReuseFreedMemory(uint64_t{1} << 40);
  BareService service(threads);
  grpc::ServerBuilder builder;
  int port = 0;
  builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
  builder.RegisterService(&service);
  const auto server = builder.BuildAndStart();
  if (server == nullptr) return 1;
  std::fprintf(stderr, "{\"event\":\"serving\",\"listen\":\"127.0.0.1:%d\"}\n", port);
  server->Wait();
  return 0;
}

}  // namespace
}  // namespace curvd::bench

int main(int argc, char** argv) {
  const int threads = argc == 2 ? std::atoi(argv[1]) : 0;
  if (threads < 1) {
    std::fprintf(stderr, "usage: %s THREADS\n", argv[0]);
    return 2;
  }
  return curvd::bench::Serve(threads);
}
