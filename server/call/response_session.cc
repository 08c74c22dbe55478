#include "server/call/response_session.h"

#include <algorithm>
#include <utility>

namespace curvd {

void ResponseSession::Accept() { is_accepted_ = accepted_due_ = true; }

void ResponseSession::SetProgressDue(bool is_due) { progress_due_ = is_due && is_accepted_ && !is_complete_; }

void ResponseSession::Complete(uint64_t points, uint64_t chunk_points, uint64_t scales) {
  is_complete_ = summary_due_ = true;
  progress_due_ = false;
  points_ = points;
  chunk_points_ = chunk_points;
  scales_ = scales;
}

ResponseSession::Message ResponseSession::Next() {
  if (std::exchange(accepted_due_, false)) return {Kind::kAccepted};
  if (std::exchange(progress_due_, false)) return {Kind::kProgress};
  if (!is_complete_) return {Kind::kNothing};
  if (next_point_ == points_ && points_ > 0 && next_scale_ + 1 < scales_) {
    ++next_scale_;
    next_point_ = 0;
  }
  if (next_point_ < points_) {
    const uint64_t first = next_point_;
    next_point_ += std::min(chunk_points_, points_ - first);
    return {Kind::kResults, first, next_point_ - first, next_scale_};
  }
  return {std::exchange(summary_due_, false) ? Kind::kSummary : Kind::kEnd};
}

}  // namespace curvd
