#include "core/scale/scouting.h"

#include <algorithm>
#include <iterator>

#include "core/scale/automatic_options.h"
#include "core/scale/judging/position_noise.h"
#include "core/scale/line_distance.h"
#include "core/scale/parts/cloud_parts.h"
#include "core/scale/scale_choice.h"

namespace curvd {
namespace {

// Scouts are sampled at so many rungs first, up to 512 neighbors.
constexpr size_t kBriefRungs = 11;
// A rung counts at a scout with this weight: its error is less than 2 to 3 times the least. So many rungs beyond are
// sampled: that a scale is too large is seen by those that are larger.
constexpr double kLeastScoutWeight = 1e-2;
constexpr size_t kRungsBeyond = 3;
// Where points without a result leave fewer scouts, they tell nothing.
constexpr size_t kFewestScouts = 48;

}  // namespace

Scouting::Scouting(const EstimatorOptions& options, const SpatialIndex& index, Pilot& pilot, PilotTable& table,
                   const EdgeRun* edges)
    : options_(options),
      index_(index),
      pilot_(pilot),
      table_(table),
      edges_(edges),
      are_brief_(options.is_automatic() && pilot.HasOthers() && pilot.most_rungs() > kBriefRungs) {
  if (are_brief_) pilot_.SetRungs(kBriefRungs);
}

// Of noisy positions the first rungs mostly do not tell enough.
bool Scouting::LooksAgain() {
  if (!are_brief_) return false;
  if (PositionsAreExact(table_)) needed_ = NeededByOthers();
  if (needed_.has_value() && needed_->rungs <= kBriefRungs) return false;
  SampleAllRungs();
  return true;
}

bool Scouting::LooksAgainAtEdges() {
  if (!are_brief_ || edges_ == nullptr || !edges_->HasEdges()) return false;
  SampleAllRungs();
  return true;
}

void Scouting::SampleAllRungs() {
  are_brief_ = false;
  needed_.reset();
  pilot_.SetRungs(pilot_.most_rungs());
  table_.assign(table_.size(), PilotPoint::None());
}

void Scouting::SpareOthers() {
  if (!options_.is_automatic() || !pilot_.HasOthers()) return;
  if (!are_brief_) needed_ = NeededByOthers();
  if (!needed_.has_value()) return;
  pilot_.SetRungs(std::min(needed_->rungs, pilot_.rung_count()));
  for (PilotPoint& point : table_) point.KeepRungs(pilot_.rung_count());
  pilot_.KeepMethods(needed_->methods);
}

std::optional<Scouting::Needed> Scouting::NeededByOthers() const {
  PilotTable scouts;
  scouts.reserve(table_.size());
  std::copy_if(table_.begin(), table_.end(), std::back_inserter(scouts),
               [](const PilotPoint& point) { return point.is_sampled(); });
  if (scouts.size() < kFewestScouts) return std::nullopt;
  DropUndeterminedAcrossLines(BoundsOf(options_, index_), scouts);
  if (edges_ != nullptr && edges_->HasEdges()) return std::nullopt;
  // A part of the cloud, even a small one, may need other rungs than the rest.
  if (ShowNoiseInParts(scouts)) return std::nullopt;
  if (IsPerPoint(options_) && SplitIntoParts(scouts) != scouts.size()) return std::nullopt;
  const auto count = FindCandidatesThatCount(scouts, BoundsOf(options_, index_), kLeastScoutWeight);
  if (!count.has_value()) return std::nullopt;
  return Needed{std::max(count->largest_rung + 1 + kRungsBeyond, kRungsThatTellNoise), count->methods};
}

}  // namespace curvd
