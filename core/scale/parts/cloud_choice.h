// What was chosen for a cloud, for each of its parts by itself.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "core/estimators/scale_ladder.h"
#include "core/scale/detail/detail_check.h"
#include "core/scale/detail/near_check.h"
#include "core/scale/pilot/pilot_table.h"
#include "core/scale/scale_choice.h"

namespace curvd {

struct PartChoice {
  PilotPoints samples;
  ScaleChoice choice;  // made of them
  bool positions_are_exact = false;
  std::optional<DetailCheck> check = std::nullopt;
  std::vector<NearCheck> near_checks = {};
};

// One part, or the two of SplitIntoParts.
class CloudChoice {
 public:
  static constexpr size_t kMostParts = 2,
                          kMostChosen = kMostParts * (ScaleChoice::kMostChosen + 1 + kMostNearChecks) + 1;

  CloudChoice() = default;
  // The samples of the second part follow those of the first in one table, which outlives the object.
  explicit CloudChoice(std::vector<PartChoice> parts) : parts_(std::move(parts)) {
    for (const PartChoice& part : parts_) {
      first_.push_back(chosen_.size());
      chosen_.insert(chosen_.end(), part.choice.chosen.begin(), part.choice.chosen.end());
      for (const ScaleCandidate& candidate : part.choice.chosen) may_be_steady_.push_back(IsSteady(candidate, part));
    }
    if (parts_.size() > 1) AddCheckOfBorder();
    for (const PartChoice& part : parts_) {
      detail_checks_.push_back(chosen_.size());
      if (part.check.has_value()) chosen_.push_back(part.check->candidate);
    }
    for (const PartChoice& part : parts_) {
      near_checks_.push_back(chosen_.size());
      for (const NearCheck& check : part.near_checks) chosen_.push_back(check.candidate);
    }
    may_be_steady_.resize(chosen_.size());  // no check is
  }

  const std::vector<PartChoice>& parts() const { return parts_; }
  // The candidates of the first part, then those of the second, then what checks them and counts nowhere: at the border
  // of both, for detail in the first and in the second, and for small bodies in each.
  const std::vector<ScaleCandidate>& chosen() const { return chosen_; }
  // The place in chosen() of a part's first.
  size_t first_of(size_t part) const { return first_[part]; }

  // Whether the estimate at a place in chosen() may hold alone where those of its part contradict each other: where
  // positions are exact, a cubic regression of normals, if none of the part's estimates looks less far by two rungs,
  // and if it is not expected to err by far more than the best.
  bool MayBeSteady(size_t estimate) const { return may_be_steady_[estimate]; }

  // The places in chosen() of PartChoice::check, if there is one, and of the first of PartChoice::near_checks: these
  // follow all others.
  size_t detail_check_of(size_t part) const { return detail_checks_[part]; }
  size_t near_checks_of(size_t part) const { return near_checks_[part]; }

  // The place in chosen() of one that counts nowhere, and looks less far than what counts most in the first part: where
  // both agree, no neighborhood reaches into the second. Nothing where there is one part, or where that one has the
  // smallest neighborhoods that there are.
  std::optional<size_t> check() const { return check_; }

  // All samples, and where those of the second part begin among them.
  PilotPoints samples() const {
    size_t size = 0;
    for (const PartChoice& part : parts_) size += part.samples.size();
    return {parts_.front().samples.data(), size};
  }
  size_t second() const { return parts_.front().samples.size(); }

  size_t bytes() const {
    size_t bytes = 0;
    for (const PartChoice& part : parts_) {
      const auto& [mean, traceless, gaussian] = part.choice.weights;
      bytes += mean.bytes() + traceless.bytes() + gaussian.bytes();
    }
    return bytes;
  }

 private:
  static bool IsSteady(const ScaleCandidate& candidate, const PartChoice& part) {
    // Normals that err where positions do not are no help: their regressions err by ten times as much as jets.
    constexpr double kMostOfLeastError = 5.0;
    if (!part.positions_are_exact || candidate.method != kRegressionMethod) return false;
    const bool looks_least_far =
        std::all_of(part.choice.chosen.begin(), part.choice.chosen.end(),
                    [&](const ScaleCandidate& other) { return candidate.rung <= other.rung + 1; });
    const auto score = std::find_if(part.choice.scores.begin(), part.choice.scores.end(),
                                    [&](const ScaleScore& of) { return of.candidate == candidate; });
    return looks_least_far && score != part.choice.scores.end() &&
           score->error <= kMostOfLeastError * LeastLocalError(part.choice);
  }

  void AddCheckOfBorder() {
    const ScaleCandidate& leading = parts_.front().choice.chosen.front();
    if (leading.rung == 0) return;
    check_ = chosen_.size();
    chosen_.push_back({leading.method, leading.rung - 1});
  }

  std::vector<PartChoice> parts_;
  std::vector<ScaleCandidate> chosen_;
  std::vector<bool> may_be_steady_;  // of each of these
  std::vector<size_t> first_, detail_checks_, near_checks_;
  std::optional<size_t> check_;
};

}  // namespace curvd
