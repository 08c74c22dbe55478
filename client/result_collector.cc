#include "client/result_collector.h"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "grpcpp/impl/codegen/proto_utils.h"

namespace curv {
namespace {

namespace v1 = curvature::v1;
namespace wire = curvature::wire;
using v1::ResultChunk;

absl::Status Broken(const std::string& what) {
  return absl::InternalError(absl::StrCat("the server broke the protocol: ", what));
}

constexpr wire::BulkLayout kResultChunk({ResultChunk::kFirstIndexFieldNumber, ResultChunk::kPointCountFieldNumber},
                                        {ResultChunk::kStatusFieldNumber, ResultChunk::kMeanCurvatureFieldNumber,
                                         ResultChunk::kGaussianCurvatureFieldNumber, ResultChunk::kK1FieldNumber,
                                         ResultChunk::kK2FieldNumber, ResultChunk::kD1FieldNumber,
                                         ResultChunk::kD2FieldNumber, ResultChunk::kRadiusFieldNumber});

// `chunk` as it would have been read in place.
wire::BulkMessage InPlace(const ResultChunk& chunk) {
  wire::BulkMessage read;
  read.numbers[ResultChunk::kFirstIndexFieldNumber] = chunk.first_index();
  read.numbers[ResultChunk::kPointCountFieldNumber] = chunk.point_count();
  read.arrays[ResultChunk::kStatusFieldNumber] = {chunk.status()};
  read.arrays[ResultChunk::kMeanCurvatureFieldNumber] = {chunk.mean_curvature()};
  read.arrays[ResultChunk::kGaussianCurvatureFieldNumber] = {chunk.gaussian_curvature()};
  read.arrays[ResultChunk::kK1FieldNumber] = {chunk.k1()};
  read.arrays[ResultChunk::kK2FieldNumber] = {chunk.k2()};
  read.arrays[ResultChunk::kD1FieldNumber] = {chunk.d1()};
  read.arrays[ResultChunk::kD2FieldNumber] = {chunk.d2()};
  read.arrays[ResultChunk::kRadiusFieldNumber] = {chunk.radius()};
  return read;
}

// Appends the values in `pieces`; false if they are not `count`.
template <typename Value>
bool Append(const wire::Pieces& pieces, size_t count, std::vector<Value>& values) {
  if (wire::SizeOf(pieces) != count * sizeof(Value)) return false;
  const size_t old_size = values.size();
  values.resize(old_size + count);
  char* out = reinterpret_cast<char*>(values.data() + old_size);
  for (const std::string_view piece : pieces) out = std::copy(piece.begin(), piece.end(), out);
  return true;
}

}  // namespace

absl::Status ResultCollector::Take(grpc::ByteBuffer& message) {
  if (summarized_) return Broken("a message follows the summary");
  wire::BulkMessage chunk;
  if (accepted_ &&
      wire::ReadBulkMessage(message, v1::EstimateCurvatureResponse::kResultFieldNumber, kResultChunk, chunk)) {
    return TakeResult(chunk);
  }
  v1::EstimateCurvatureResponse response;
  if (!grpc::SerializationTraits<v1::EstimateCurvatureResponse>::Deserialize(&message, &response).ok()) {
    return Broken("a message cannot be parsed");
  }
  return TakeResponse(response);
}

absl::Status ResultCollector::TakeResponse(const v1::EstimateCurvatureResponse& response) {
  if (response.has_accepted()) return TakeAccepted(response.accepted());
  if (!accepted_) return Broken("the first message is not Accepted");
  if (response.has_progress()) {
    progress_ = response.progress();
    return absl::OkStatus();
  }
  if (response.has_result()) return TakeResult(InPlace(response.result()));
  if (response.has_summary()) return TakeSummary(response.summary());
  return absl::OkStatus();  // of a newer server; what must not be missed is counted
}

absl::Status ResultCollector::Finish() const {
  if (!accepted_) return Broken("the call ended with OK before it was accepted");
  if (!summarized_) {
    return Broken(
        absl::StrCat("the call ended with OK but without a summary, after ", received_, " of ", points_, " results"));
  }
  return absl::OkStatus();
}

absl::Status ResultCollector::TakeAccepted(const v1::Accepted& accepted) {
  if (accepted_) return Broken("Accepted came twice");
  accepted_ = true;
  limits_ = accepted.limits();
  result_.summary.request_id = accepted.request_id();
  return absl::OkStatus();
}

// Pages are touched chunk by chunk, when their values are there to be written.
void ResultCollector::MakeRoom() {
  for (std::vector<float>* scalars : {&result_.mean, &result_.gaussian, &result_.k1, &result_.k2, &result_.radius}) {
    scalars->reserve(points_);
  }
  result_.d1.reserve(3 * points_);
  result_.d2.reserve(3 * points_);
  result_.status.reserve(points_);
}

absl::Status ResultCollector::TakeResult(const wire::BulkMessage& chunk) {
  const uint64_t first = chunk.numbers[ResultChunk::kFirstIndexFieldNumber];
  const uint64_t count = chunk.numbers[ResultChunk::kPointCountFieldNumber];
  if (first != received_ || count == 0 || count > points_ - received_) {
    return Broken(absl::StrCat("a result chunk holds ", count, " points from index ", first, ", but ", received_,
                               " of ", points_, " are here"));
  }
  if (received_ == 0) MakeRoom();
  const auto& arrays = chunk.arrays;
  const bool fits = Append(arrays[ResultChunk::kStatusFieldNumber], count, result_.status) &&
                    Append(arrays[ResultChunk::kMeanCurvatureFieldNumber], count, result_.mean) &&
                    Append(arrays[ResultChunk::kGaussianCurvatureFieldNumber], count, result_.gaussian) &&
                    Append(arrays[ResultChunk::kK1FieldNumber], count, result_.k1) &&
                    Append(arrays[ResultChunk::kK2FieldNumber], count, result_.k2) &&
                    Append(arrays[ResultChunk::kD1FieldNumber], 3 * count, result_.d1) &&
                    Append(arrays[ResultChunk::kD2FieldNumber], 3 * count, result_.d2) &&
                    Append(arrays[ResultChunk::kRadiusFieldNumber], count, result_.radius);
  if (!fits) {
    return Broken(absl::StrCat("an array of the result chunk from index ", first, " does not hold ", count, " points"));
  }
  received_ += count;
  return absl::OkStatus();
}

absl::Status ResultCollector::TakeSummary(const v1::Summary& summary) {
  if (summary.point_count() != points_ || received_ != points_) {
    return Broken(absl::StrCat("the summary counts ", summary.point_count(), " points, ", received_, " of ", points_,
                               " results came"));
  }
  EstimateSummary& out = result_.summary;
  const v1::StatusCounts& counts = summary.status_counts();
  out.status_counts = {0,
                       counts.ok(),
                       counts.too_few_neighbors(),
                       counts.degenerate_area(),
                       counts.invalid_input(),
                       counts.inconsistent_normals(),
                       counts.singular_fit()};
  std::array<uint64_t, kStatusWords.size()> counted{};
  uint64_t rest = points_;  // mostly none after the first
  for (uint8_t status = 1; rest > 0 && status < counted.size(); ++status) {
    counted[status] = std::count(result_.status.begin(), result_.status.end(), status);
    rest -= counted[status];
  }
  counted[0] = rest;
  if (counted != out.status_counts) return Broken("the summary's status counts are not those of the results");
  out.points = points_;
  out.normals_rescaled = summary.normals_rescaled();
  out.receive_seconds = summary.seconds().receive();
  out.queue_seconds = summary.seconds().queue();
  out.index_seconds = summary.seconds().index();
  out.estimate_seconds = summary.seconds().estimate();
  out.send_seconds = summary.seconds().send();
  out.peak_bytes = summary.peak_bytes();
  summarized_ = true;
  return absl::OkStatus();
}

}  // namespace curv
