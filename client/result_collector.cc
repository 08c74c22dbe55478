#include "client/result_collector.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"

namespace curv {
namespace {

namespace v1 = curvature::v1;

absl::Status Broken(const std::string& what) {
  return absl::InternalError(absl::StrCat("the server broke the protocol: ", what));
}

// Appends `bytes` to `values`; false if they are not count * width floats.
bool Append(const std::string& bytes, uint64_t count, size_t width, std::vector<float>& values) {
  if (bytes.size() != count * width * sizeof(float)) return false;
  // The standard library of Debian aligns a string's bytes for floats. Inserted, and not resized and copied over, they
  // are written once.
  const auto* floats = reinterpret_cast<const float*>(bytes.data());
  values.insert(values.end(), floats, floats + count * width);
  return true;
}

}  // namespace

absl::Status ResultCollector::Take(const v1::EstimateCurvatureResponse& response) {
  if (summarized_) return Broken("a message follows the summary");
  if (response.has_accepted()) return TakeAccepted(response.accepted());
  if (!accepted_) return Broken("the first message is not Accepted");
  if (response.has_progress()) {
    progress_ = response.progress();
    return absl::OkStatus();
  }
  if (response.has_result()) return TakeResult(response.result());
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

absl::Status ResultCollector::TakeResult(const v1::ResultChunk& chunk) {
  const uint64_t first = chunk.first_index(), count = chunk.point_count();
  if (first != received_ || count == 0 || count > points_ - received_) {
    return Broken(absl::StrCat("a result chunk holds ", count, " points from index ", first, ", but ", received_,
                               " of ", points_, " are here"));
  }
  if (received_ == 0) MakeRoom();
  const bool fits = chunk.status().size() == count && Append(chunk.mean_curvature(), count, 1, result_.mean) &&
                    Append(chunk.gaussian_curvature(), count, 1, result_.gaussian) &&
                    Append(chunk.k1(), count, 1, result_.k1) && Append(chunk.k2(), count, 1, result_.k2) &&
                    Append(chunk.d1(), count, 3, result_.d1) && Append(chunk.d2(), count, 3, result_.d2) &&
                    Append(chunk.radius(), count, 1, result_.radius);
  if (!fits) {
    return Broken(absl::StrCat("an array of the result chunk from index ", first, " does not hold ", count, " points"));
  }
  result_.status.insert(result_.status.end(), chunk.status().begin(), chunk.status().end());
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
