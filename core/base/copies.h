// Points that are there several times, but for rounding: when two scans of one surface are merged that share points, or
// one is moved to another frame and back. They share their noise, which halves of a neighborhood would agree about.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace curvd {

// Tells copies from points that lie close by chance, or on the lines of a scan: those have eight times as many pairs
// and more within eight times the distance, and copies have hardly any more.
class NearCopies {
 public:
  // Of `count` points over a disk of this radius.
  NearCopies(float radius, size_t count)
      : distance_(radius * std::sqrt(std::numbers::pi_v<float> / static_cast<float>(count)) / 256.0f), count_(count) {}

  // As near as this are copies: a 256th of the mean distance of points.
  float distance() const { return distance_; }
  // Pairs are looked for up to here.
  float clearance() const { return 8.0f * distance_; }

  void AddPair(float squared_distance) {
    if (squared_distance <= clearance() * clearance()) ++close_pairs_;
    if (squared_distance <= distance_ * distance_) ++near_pairs_;
  }

  // Whether the points have copies, now that all pairs are added. Fewer than one in fifty are left to chance.
  bool Exist() const { return near_pairs_ >= std::max<size_t>(4, count_ / 50) && 2 * near_pairs_ >= close_pairs_; }

 private:
  float distance_;
  size_t count_, near_pairs_ = 0, close_pairs_ = 0;
};

}  // namespace curvd
