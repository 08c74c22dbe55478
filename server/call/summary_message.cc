#include "server/call/summary_message.h"

namespace curvd {

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

  curvature::v1::PhaseSeconds* seconds = summary->mutable_seconds();
  seconds->set_receive(record.seconds.receive.value_or(0.0));
  seconds->set_queue(record.seconds.queue.value_or(0.0));
  seconds->set_index(record.seconds.index.value_or(0.0));
  seconds->set_estimate(record.seconds.estimate.value_or(0.0));
  seconds->set_send(record.seconds.send.value_or(0.0));
}

}  // namespace curvd
