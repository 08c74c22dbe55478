#include "server/call/summary_message.h"

#include <algorithm>
#include <string>

#include "absl/strings/str_format.h"

namespace curvd {
namespace {

// What a person should know who has sent normals that contradict each other.
std::string OpposedNormalsText(uint64_t points, const CallRecord& record) {
  const double share = static_cast<double>(record.agreement.opposed_pairs) /
                       static_cast<double>(std::max<uint64_t>(record.agreement.near_pairs, 1));
  return absl::StrFormat(
      "normals point to opposite sides of one surface around %u of %u points, which therefore have no curvature "
      "(opposed_normals); %.2g %% of the pairs of nearest neighbors are opposed, %u patches flipped. Elsewhere the "
      "sign of curvature may be wrong: make all normals point to one side, outward on closed surfaces, and estimate "
      "again",
      points, record.points_received, 100.0 * share, record.agreement.flipped_patches);
}

void AddWarnings(const CallRecord& record, curvature::v1::Summary* summary) {
  if (record.agreement.seam_points == 0) return;
  const uint64_t points = record.status_counts[static_cast<size_t>(PointStatus::kOpposedNormals)];
  curvature::v1::Warning* warning = summary->add_warnings();
  warning->set_code(curvature::v1::WARNING_CODE_OPPOSED_NORMALS);
  warning->set_message(OpposedNormalsText(points, record));
  warning->set_point_count(points);
  warning->set_pair_count(record.agreement.near_pairs);
  warning->set_opposed_pair_count(record.agreement.opposed_pairs);
  warning->set_flipped_patch_count(record.agreement.flipped_patches);
}

}  // namespace

void FillSummary(const CallRecord& record, curvature::v1::Summary* summary) {
  summary->set_point_count(record.points_received);
  summary->set_normals_rescaled(record.normals_rescaled);
  summary->set_peak_bytes(record.peak_bytes);

  const auto count = [&record](PointStatus status) { return record.status_counts[static_cast<size_t>(status)]; };
  curvature::v1::StatusCounts* counts = summary->mutable_status_counts();
  counts->set_ok(count(PointStatus::kOk));
  counts->set_too_few_neighbors(count(PointStatus::kTooFewNeighbors));
  counts->set_degenerate_area(count(PointStatus::kDegenerateArea));
  counts->set_invalid_input(count(PointStatus::kInvalidInput));
  counts->set_inconsistent_normals(count(PointStatus::kInconsistentNormals));
  counts->set_singular_fit(count(PointStatus::kSingularFit));
  counts->set_opposed_normals(count(PointStatus::kOpposedNormals));

  curvature::v1::PhaseSeconds* seconds = summary->mutable_seconds();
  seconds->set_receive(record.seconds.receive.value_or(0.0));
  seconds->set_queue(record.seconds.queue.value_or(0.0));
  seconds->set_index(record.seconds.index.value_or(0.0));
  seconds->set_estimate(record.seconds.estimate.value_or(0.0));
  seconds->set_send(record.seconds.send.value_or(0.0));
  AddWarnings(record, summary);
}

}  // namespace curvd
