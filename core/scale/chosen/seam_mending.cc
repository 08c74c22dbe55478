#include "core/scale/chosen/seam_mending.h"

#include <algorithm>
#include <functional>

namespace curvd {

// The points of the run of a group that get results.
struct SeamMending::Points {
  size_t size = 0;
  AutomaticScratch::OfPoints<size_t> slots;
  AutomaticScratch::OfPoints<bool> is_closed;         // whether the next larger estimates are not asked any more
  AutomaticScratch::OfPoints<bool> reaches;           // whether the result of the whole average reaches a seam
  AutomaticScratch::OfPoints<PointCurvature> before;  // that result

  bool AreClosed(size_t count) const {
    return std::all_of(is_closed.begin(), is_closed.begin() + count, std::identity());
  }
};

absl::Status SeamMending::Mend(size_t group, AutomaticScratch& s) const {
  s.rest = 0;
  const SeamReach::Group found = reach_.ReachingIn(group, results_);
  Points at;
  at.size = found.size - std::min(s.first_point, found.size);
  for (size_t i = 0; i < at.size; ++i) {
    at.slots[i] = found.slots[s.first_point + i];
    at.reaches[i] = found.reaches[s.first_point + i];
    at.is_closed[i] = !at.reaches[i];
    at.before[i] = results_[at.slots[i]];
  }
  if (at.AreClosed(at.size)) return absl::OkStatus();
  estimates_.Start(group, s);
  for (const size_t estimate : estimates_.by_count()) {
    if (at.AreClosed(s.points.size)) break;
    bool is_asked = false;
    for (size_t i = 0; i < s.points.size; ++i) {
      is_asked = is_asked || (!at.is_closed[i] && estimates_.IsOfPart(i, estimate, s));
    }
    if (!is_asked) continue;
    if (absl::Status status = estimates_.Run(group, estimate, nullptr, s); !status.ok()) return status;
    for (size_t i = 0; i < s.points.size; ++i) AddShortOfSeams(i, estimate, at, s);
  }
  return Finish(group, at, s);
}

bool SeamMending::Reaches(size_t i, float radius, const AutomaticScratch& s) const {
  SeamReach::Query query;
  s.points.query.Get(i, query.position.data());
  s.points.normal.Get(i, query.normal.data());
  return reach_.Reaches(query, radius);
}

// Neighborhoods that are larger than one which reaches across a seam do so as well.
void SeamMending::AddShortOfSeams(size_t i, size_t estimate, Points& at, AutomaticScratch& s) const {
  if (at.is_closed[i] || !estimates_.IsOfPart(i, estimate, s)) return;
  const PointCurvature& found = results_[s.points.slot[i]];
  if (found.status == PointStatus::kOk) at.is_closed[i] = Reaches(i, found.radius, s);
  if (!at.is_closed[i]) estimates_.Add(found, i, estimate, s);
}

// Writes the points that have estimates left; all others get back what they were.
absl::Status SeamMending::Finish(size_t group, const Points& at, AutomaticScratch& s) const {
  const auto is_mended = [&](size_t i) { return i < s.points.size && s.blends[i].weight() > 0.0; };
  for (size_t i = 0; i < at.size; ++i) {
    results_[at.slots[i]] = is_mended(i) ? ChosenEstimates::Blended(s, i) : at.before[i];
  }
  absl::Status status = estimates_.EstimateOneSided(group, s);
  if (status.ok() && own_fits_ != nullptr) {
    status = own_fits_->EstimateWithin(
        group, [&](size_t i) { return at.reaches[i] && !is_mended(i); },
        [&](size_t i, float radius) { return Reaches(i, radius, s); }, s);
  }
  if (choices_ != nullptr) choices_->Start(s);
  for (size_t i = 0; i < s.points.size; ++i) {
    if (!is_mended(i) && !s.own_fits[i].has_value()) continue;
    // It counts as OK already.
    if (results_[at.slots[i]].status != PointStatus::kOk) {
      results_[at.slots[i]] = at.before[i];
    } else if (choices_ != nullptr) {
      choices_->WriteMended(i, s);
    }
  }
  return status;
}

}  // namespace curvd
