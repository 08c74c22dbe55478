#include "client/result_collector.h"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "grpcpp/impl/codegen/proto_utils.h"

namespace curv {
namespace {

namespace v1 = curvature::v1;
namespace wire = curvature::wire;
using v1::ResultChunk;

absl::Status Broken(const std::string& what) {
  return absl::InternalError(absl::StrCat("the server broke the protocol: ", what));
}

wire::BulkLayout MakeLayout() {
  wire::BulkLayout layout({ResultChunk::kFirstIndexFieldNumber, ResultChunk::kPointCountFieldNumber,
                           ResultChunk::kNeighborCountFieldNumber},
                          {});
  for (const wire::ResultColumn& column : wire::ResultColumns()) {
    if (column.field < wire::kFieldEnd) layout.AddArray(column.field);  // chunks with others go through protobuf
  }
  return layout;
}

const wire::BulkLayout& ChunkLayout() {
  static const wire::BulkLayout layout = MakeLayout();
  return layout;
}

// `chunk` as it would have been read in place.
wire::BulkMessage InPlace(const ResultChunk& chunk) {
  wire::BulkMessage read;
  read.numbers[ResultChunk::kFirstIndexFieldNumber] = chunk.first_index();
  read.numbers[ResultChunk::kPointCountFieldNumber] = chunk.point_count();
  read.numbers[ResultChunk::kNeighborCountFieldNumber] = chunk.neighbor_count();
  for (const wire::ResultColumn& column : wire::ResultColumns()) {
    if (column.field >= wire::kFieldEnd) continue;
    std::string scratch;  // not used: the field is a string of its own
    const auto* field = ResultChunk::descriptor()->FindFieldByNumber(column.field);
    read.arrays[column.field] = {chunk.GetReflection()->GetStringReference(chunk, field, &scratch)};
  }
  return read;
}

EstimateWarning FromProto(const v1::Warning& warning) {
  const std::string name = v1::WarningCode_Name(warning.code());  // empty for a code that is new
  return {name.empty() ? absl::StrCat(static_cast<int>(warning.code()))
                       : std::string(absl::StripPrefix(name, "WARNING_CODE_")),
          warning.message(),
          warning.point_count(),
          warning.pair_count(),
          warning.opposed_pair_count(),
          warning.flipped_patch_count()};
}

NormalsReport FromProto(const v1::NormalsReport& report) {
  NormalsReport out;
  if (report.method() != v1::NORMAL_METHOD_UNSPECIFIED) out.method = static_cast<NormalMethod>(report.method());
  out.neighbor_count = report.neighbor_count();
  if (report.has_noise()) out.noise = report.noise();
  out.missing = report.missing_count();
  out.turned = report.turned_count();
  out.pieces = report.piece_count();
  out.closed_pieces = report.closed_piece_count();
  out.closed_area_share = report.closed_area_share();
  out.repaired = report.repaired_count();
  out.inner_walls = report.inner_wall_count();
  if (report.has_certificate()) out.certificate = report.certificate();
  if (report.has_max_trusted_certificate()) out.max_trusted_certificate = report.max_trusted_certificate();
  out.doubtful = report.doubtful();
  if (report.has_noisy_part()) {
    const v1::NoisyNormals& noisy = report.noisy_part();
    out.noisy_part = {static_cast<NormalMethod>(noisy.method()), noisy.neighbor_count(), std::nullopt, noisy.share()};
    if (noisy.has_noise()) out.noisy_part->noise = noisy.noise();
  }
  return out;
}

// The number of an estimator that the contract has gained since.
std::string NameOf(v1::Estimator estimator) {
  const std::string name(EstimatorName(static_cast<Estimator>(estimator)));
  return name.empty() ? absl::StrCat(static_cast<int>(estimator)) : name;
}

ScaleReport FromProto(const v1::ScaleReport& report) {
  ScaleReport out;
  for (const v1::ScaleOutcome& one : report.outcomes()) {
    out.outcomes.push_back({NameOf(one.estimator()), one.degree(), one.neighbor_count(), one.error(), one.noise(),
                            one.bias(), one.share()});
  }
  out.sampled_points = report.sampled_point_count();
  out.position_noise = report.position_noise();
  if (report.has_normal_noise()) out.normal_noise = report.normal_noise();
  const auto fit_of = [](const v1::FittedNormals& fit) {
    return FittedNormals{static_cast<NormalMethod>(fit.method()), fit.neighbor_count()};
  };
  if (report.has_fitted_normals()) out.fitted_normals = fit_of(report.fitted_normals());
  if (report.has_normals_made_anew()) out.normals_made_anew = fit_of(report.normals_made_anew());
  return out;
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

NamedColumn EmptyColumn(const wire::ResultColumn& column) {
  NamedColumn empty{column.name, column.width, {}};
  if (column.type == v1::COLUMN_TYPE_UINT8) empty.values = std::vector<uint8_t>();
  return empty;
}

void Store(NamedColumn column, CurvatureResult& result) {
  auto* floats = std::get_if<std::vector<float>>(&column.values);
  for (const ResultMember& member : ResultMembers()) {
    if (member.name != column.name || floats == nullptr) continue;
    result.*member.values = std::move(*floats);
    return;
  }
  result.others.push_back(std::move(column));
}

}  // namespace

absl::Status ResultCollector::Take(grpc::ByteBuffer& message) {
  if (summarized_) return Broken("a message follows the summary");
  wire::BulkMessage chunk;
  if (accepted_ &&
      wire::ReadBulkMessage(message, v1::EstimateCurvatureResponse::kResultFieldNumber, ChunkLayout(), chunk)) {
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
        absl::StrCat("the call ended with OK but without a summary, after ", received_, " of ", results_, " results"));
  }
  return absl::OkStatus();
}

absl::Status ResultCollector::TakeAccepted(const v1::Accepted& accepted) {
  if (accepted_) return Broken("Accepted came twice");
  accepted_ = true;
  limits_ = accepted.limits();
  summary_.request_id = accepted.request_id();
  if (normals_ != NormalSource::kGiven && accepted.normals().source() != static_cast<v1::NormalSource>(normals_)) {
    return absl::UnimplementedError("the server is too old to make or orient normals: it takes them as they are given");
  }
  if (needs_scale_ && !accepted.options().has_automatic_scale()) {
    return absl::UnimplementedError("the server is too old to choose a scale: it knows no automatic_scale");
  }
  if (!std::equal(counts_.begin(), counts_.end(), accepted.options().neighbor_counts().begin(),
                  accepted.options().neighbor_counts().end())) {
    return absl::UnimplementedError("the server is too old to take several neighbor counts");
  }
  if (needs_part_ && !accepted.has_part()) {
    return absl::UnimplementedError("the server is too old to know of ids, roles or lattices");
  }
  if (accepted.has_reach_factor()) summary_.reach_factor = accepted.reach_factor();
  const auto comes = [&accepted](v1::Quantity quantity) {
    const auto& told = accepted.quantities();
    const bool is_curvature = quantity < v1::QUANTITY_NORMALS;  // servers that tell nothing know no other
    return told.empty() ? is_curvature : std::find(told.begin(), told.end(), quantity) != told.end();
  };
  for (const std::string& name : quantities_) {
    if (const auto quantity = wire::QuantityOf(name); !quantity || !comes(*quantity)) {
      return Broken(absl::StrCat("it accepted the call without the quantity ", name));
    }
  }
  for (const wire::ResultColumn& column : wire::ResultColumns()) {
    if (column.quantity == v1::QUANTITY_UNSPECIFIED || comes(column.quantity)) {
      columns_.push_back({&column, EmptyColumn(column)});
    }
  }
  return absl::OkStatus();
}

absl::Status ResultCollector::CheckScale(uint64_t neighbor_count) {
  if (received_ == results_ && scales_.size() + 1 < counts_.size()) {
    CountStatuses();
    scales_.push_back(TakeColumns());
    received_ = 0;
  }
  const uint64_t expected = counts_.empty() ? 0 : counts_[scales_.size()];
  if (neighbor_count == expected) return absl::OkStatus();
  return Broken(absl::StrCat("a result chunk is of ", neighbor_count, " neighbors, not of ", expected));
}

absl::Status ResultCollector::TakeResult(const wire::BulkMessage& chunk) {
  if (absl::Status status = CheckScale(chunk.numbers[ResultChunk::kNeighborCountFieldNumber]); !status.ok()) {
    return status;
  }
  const uint64_t first = chunk.numbers[ResultChunk::kFirstIndexFieldNumber];
  const uint64_t count = chunk.numbers[ResultChunk::kPointCountFieldNumber];
  if (first != received_ || count == 0 || count > results_ - received_) {
    return Broken(absl::StrCat("a result chunk holds ", count, " points from index ", first, ", but ", received_,
                               " of ", results_, " are here"));
  }
  size_t bytes = 0;
  for (const wire::Pieces& array : chunk.arrays) bytes += wire::SizeOf(array);
  for (Collected& collected : columns_) {
    const wire::Pieces& array = chunk.arrays[collected.column->field];
    const size_t scalars = count * collected.column->width;
    const auto append = [&](auto& values) {
      // Pages are touched chunk by chunk, when their values are there to be written.
      if (received_ == 0) values.reserve(results_ * collected.column->width);
      return Append(array, scalars, values);
    };
    if (!std::visit(append, collected.values.values)) {
      return Broken(absl::StrCat("the array ", collected.column->name, " of the result chunk from index ", first,
                                 " does not hold ", count, " points"));
    }
    bytes -= wire::SizeOf(array);
  }
  if (bytes > 0) return Broken("a result chunk holds an array of a quantity that Accepted does not tell of");
  received_ += count;
  return absl::OkStatus();
}

const std::vector<uint8_t>& ResultCollector::Statuses() const {
  const auto found = std::find_if(columns_.begin(), columns_.end(), [](const Collected& collected) {
    return collected.column->field == ResultChunk::kStatusFieldNumber;
  });
  return std::get<std::vector<uint8_t>>(found->values.values);
}

void ResultCollector::CountStatuses() {
  const std::vector<uint8_t>& statuses = Statuses();
  uint64_t rest = statuses.size();  // mostly none after the first
  for (uint8_t status = 1; rest > 0 && status < counted_.size(); ++status) {
    const uint64_t count = std::count(statuses.begin(), statuses.end(), status);
    counted_[status] += count;
    rest -= count;
  }
  counted_[0] += rest;  // of statuses that the contract has gained since
}

CurvatureResult ResultCollector::TakeColumns() {
  CurvatureResult result;
  if (!counts_.empty()) result.neighbor_count = counts_[scales_.size()];
  for (Collected& collected : columns_) {
    NamedColumn values = std::exchange(collected.values, EmptyColumn(*collected.column));
    if (collected.column->field == ResultChunk::kStatusFieldNumber) {
      result.status = std::get<std::vector<uint8_t>>(std::move(values.values));
    } else {
      Store(std::move(values), result);
    }
  }
  return result;
}

CurvatureResult ResultCollector::Release() {
  CurvatureResult result;
  if (counts_.empty()) {
    result = TakeColumns();
  } else {
    while (scales_.size() < counts_.size()) scales_.push_back(TakeColumns());  // more than one of an empty cloud alone
    for (const ResultMember& member : ResultMembers()) {
      if (!member.is_of_normals) continue;
      result.*member.values = std::move(scales_.front().*member.values);
      for (CurvatureResult& scale : scales_) scale.*member.values = {};
    }
    result.scales = std::move(scales_);
  }
  result.summary = std::move(summary_);
  return result;
}

absl::Status ResultCollector::TakeSummary(const v1::Summary& summary) {
  const bool has_all_scales = results_ == 0 || counts_.empty() || scales_.size() + 1 == counts_.size();
  if (!has_all_scales) {
    return Broken(absl::StrCat("the summary came without results of ", counts_[scales_.size() + 1], " neighbors"));
  }
  if (summary.point_count() != points_ || received_ != results_) {
    return Broken(absl::StrCat("the summary counts ", summary.point_count(), " points, ", received_, " of ", results_,
                               " results came"));
  }
  EstimateSummary& out = summary_;
  const v1::StatusCounts& counts = summary.status_counts();
  out.status_counts = {0,
                       counts.ok(),
                       counts.too_few_neighbors(),
                       counts.degenerate_area(),
                       counts.invalid_input(),
                       counts.inconsistent_normals(),
                       counts.singular_fit(),
                       counts.opposed_normals(),
                       counts.outlier()};
  CountStatuses();
  out.status_counts[0] = counted_[0];
  if (counted_ != out.status_counts) return Broken("the summary's status counts are not those of the results");
  out.points = points_;
  out.normals_rescaled = summary.normals_rescaled();
  out.receive_seconds = summary.seconds().receive();
  out.queue_seconds = summary.seconds().queue();
  out.index_seconds = summary.seconds().index();
  out.normals_seconds = summary.seconds().normals();
  out.orientation_seconds = summary.seconds().orientation();
  out.estimate_seconds = summary.seconds().estimate();
  out.send_seconds = summary.seconds().send();
  out.peak_bytes = summary.peak_bytes();
  if (summary.has_normals()) out.normals = FromProto(summary.normals());
  if (summary.has_scale()) out.scale = FromProto(summary.scale());
  out.warnings.clear();
  for (const v1::Warning& warning : summary.warnings()) out.warnings.push_back(FromProto(warning));
  summarized_ = true;
  return absl::OkStatus();
}

}  // namespace curv
