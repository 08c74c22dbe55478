// Which of several fits a normal was made by.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/median.h"
#include "core/normals/normal_fit.h"
#include "core/normals/trust/fitted_normals.h"

namespace curvd {

// What a normal that was made by one of the fits leaves of it is rounding; the other fits differ by what noise, and
// uneven points, make of one neighbor more or less.
class FitMatch {
 public:
  // The squared difference of the normal from that of the fit of so many neighbors. NaN: there is no such fit.
  void Take(uint32_t neighbor_count, double difference) {
    if (difference < least_) {
      least_of_others_ = std::exchange(least_, difference);
      count_ = neighbor_count;
    } else if (difference < least_of_others_) {
      least_of_others_ = difference;
    }
  }
  // Whether the fits were enough to tell.
  bool is_known() const { return least_of_others_ < kNone; }
  // How many neighbors have the fit that the normal was made by; 0: there is no such fit. Where normals come from
  // elsewhere, chance makes it another number at each of few points.
  uint32_t count() const { return is_known() && least_ <= kMostOfOthers * least_of_others_ ? count_ : 0; }
  // The squared difference of the next fit.
  double least_of_others() const { return least_of_others_; }

 private:
  static constexpr double kNone = std::numeric_limits<double>::infinity();
  static constexpr double kMostOfOthers = 0.01;

  double least_ = kNone, least_of_others_ = kNone;
  uint32_t count_ = 0;
};

// What a probe finds: the fit that the normals were made by, and the one whose halves tell of their noise: the same, or
// planes of about its errors, if it has too few neighbors for halves; none where halves would share most of its errors.
struct FoundFit {
  FittedNormals made_by;
  std::optional<NormalFit> of_halves;
};

// A sample whose normal was made by a fit: squared differences of the normals of other fits.
struct FittedSample {
  double nearest;   // of those with other numbers of neighbors: the least
  double of_half;   // of the fit of half as many neighbors; infinity or NaN: there is none
  double of_twice;  // of the fit of twice as many
};

// The samples whose normals were made by one fit.
class FitAgreement {
 public:
  void Add(const FittedSample& sample) { samples_.push_back(sample); }
  size_t size() const { return samples_.size(); }

  // Whether so many of the samples can tell what the cloud's normals were made by. They cannot where neighborhoods are
  // copies of each other, as on a grid without noise: what chance makes of one it makes of all.
  bool IsEnough(size_t known_samples) const {
    constexpr size_t kFewest = 10;
    constexpr double kLeastShare = 0.7;
    // Of the quartiles of what differs by chance: 5 in the mean, where squared differences are as those of noise.
    constexpr double kLeastSpread = 1.5;
    if (size() < kFewest || static_cast<double>(size()) < kLeastShare * static_cast<double>(known_samples))
      return false;
    std::vector<double> nearest = ValuesOf(&FittedSample::nearest);
    std::sort(nearest.begin(), nearest.end());
    return nearest[nearest.size() * 3 / 4] >= kLeastSpread * nearest[nearest.size() / 4];
  }

  // Whether the fits' normals err by noise more than by bends of the surface, which halves of the neighbors share, and
  // cannot show. What noise does to a normal falls with the number of neighbors: the fits of twice as many differ by a
  // fourth of what those of half as many do. What bends do grows with it, and differs by four times as much.
  bool IsMadeByNoise() const {
    constexpr double kMostOfTwice = 0.6;
    // Planes that noise turns by 20 degrees differ less and less the more there is of it.
    constexpr double kMuchNoise = 0.1, kMostOfTwiceInMuchNoise = 1.0;
    std::vector<double> of_half = ValuesOf(&FittedSample::of_half), of_twice = ValuesOf(&FittedSample::of_twice);
    if (2 * of_half.size() < size() || 2 * of_twice.size() < size()) return false;
    const double half = Median(of_half);
    return Median(of_twice) <= (half > kMuchNoise ? kMostOfTwiceInMuchNoise : kMostOfTwice) * half;
  }

 private:
  // Those that are finite.
  std::vector<double> ValuesOf(double FittedSample::*member) const {
    std::vector<double> values;
    for (const FittedSample& sample : samples_) {
      if (std::isfinite(sample.*member)) values.push_back(sample.*member);
    }
    return values;
  }

  std::vector<FittedSample> samples_;
};

// The samples by the number of neighbors of the fit that each was made by.
class FitVotes {
 public:
  // A count of 0: by none. Those of which that is not known do not count.
  void Add(bool is_known, uint32_t count, const FittedSample& sample) {
    known_ += is_known ? 1 : 0;
    if (count > 0) agreements_[count].Add(sample);
  }
  size_t known() const { return known_; }
  // The number that most have; 0 and none where there are no votes.
  std::pair<uint32_t, FitAgreement> Most() const {
    std::pair<uint32_t, FitAgreement> most;
    for (const auto& vote : agreements_) {
      if (vote.second.size() > most.second.size()) most = vote;
    }
    return most;
  }

 private:
  size_t known_ = 0;
  std::map<uint32_t, FitAgreement> agreements_;
};

}  // namespace curvd
