// A part of a sample that is judged by itself.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/normals/sample_table.h"

namespace curvd {

// A value: whoever looks at another part takes another view. Thread-safe while nobody writes outcomes of the table.
class SampleView {
 public:
  // Where an outcome belongs: to this part; to it, but with many neighbors that do not; or to another part.
  enum class Part : uint8_t { kOwn, kMixed, kOther };

  // The whole sample. REQUIRES: `table` outlives the view.
  explicit SampleView(const SampleTable& table) : table_(&table) {}
  // `parts`: where each outcome belongs, candidate by candidate; empty: all are kOwn. `share`: of the cloud's points,
  // those of the part. `group_noises`: by group, the variance of its noise in the index's unit, 0 where it is not
  // known; empty: of no group.
  SampleView(const SampleTable& table, std::vector<Part> parts, double share, std::vector<double> group_noises)
      : table_(&table), parts_(std::move(parts)), share_(share), group_noises_(std::move(group_noises)) {}

  const SampleTable& table() const { return *table_; }
  const std::vector<SampleTable::Candidate>& candidates() const { return table_->candidates(); }
  size_t sample_count() const { return table_->sample_count(); }
  const SampleTable::Outcome& outcome(size_t candidate, size_t sample) const {
    return table_->outcome(candidate, sample);
  }
  Part part(size_t candidate, size_t sample) const {
    return parts_.empty() ? Part::kOwn : parts_[candidate * sample_count() + sample];
  }
  double share() const { return share_; }

  // Whether the candidate fits that point, and the outcome is the part's own.
  bool Counts(size_t candidate, size_t sample) const {
    return outcome(candidate, sample).is_fitted && part(candidate, sample) == Part::kOwn;
  }
  // The variance of the noise around a point of the sample: that of its group, if it is known; else that of the
  // standard deviation `sigma`.
  double NoiseAt(size_t sample, double sigma) const {
    const double of_group = group_noises_.empty() ? 0.0 : group_noises_[sample / SampleTable::kPointsPerGroup];
    return of_group > 0.0 ? of_group : sigma * sigma;
  }

 private:
  const SampleTable* table_;
  std::vector<Part> parts_;
  double share_ = 1.0;
  std::vector<double> group_noises_;
};

}  // namespace curvd
