// Which points of a cloud lie beside a sharp edge, and how far others are from the nearest of them.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/index/spatial_index.h"
#include "core/scale/edges/one_side.h"

namespace curvd {

// Usage: SetTrend of every point; MarkGroup of every group; Finish; then ask. The first two are thread-safe for
// distinct groups, and const methods are.
class EdgeMarks {
 private:
  struct Trend {
    float roughness, slope, spread, spread_in_two, spread_in_three;
  };

 public:
  // `index` outlives the object. May throw std::bad_alloc.
  explicit EdgeMarks(const SpatialIndex& index);

  // How the normals around a point change (core/scale/edges/one_side.h).
  void SetTrend(size_t place, const NormalTrend& trend) {
    trends_[place] = {static_cast<float>(trend.roughness), static_cast<float>(trend.slope),
                      static_cast<float>(trend.spread), static_cast<float>(trend.spread_in_two),
                      static_cast<float>(trend.spread_in_three)};
  }
  float RoughnessAt(size_t place) const { return trends_[place].roughness; }

  // Marks the points of a group whose normals are rougher than noise can make them: that of the normals, which makes
  // them as rough as `normal_noise` at most places, and that of positions, of this standard deviation in the index's
  // unit, which moves a point to where the normal is another one; and which are of two or three faces. One to three
  // such points of a group are chance, and not marked.
  void MarkGroup(size_t group, double normal_noise, double position_noise);
  void Finish();

  // Points whose normals are rougher than noise, as far as groups are marked, and those of them that lie beside an
  // edge.
  size_t rough_count() const { return rough_count_; }
  size_t edge_count() const { return edge_count_; }
  bool HasEdges() const { return !below_.empty() && below_.front() != 0; }
  // To the nearest point beside an edge, squared; `most` if none is nearer than that.
  float SquaredDistance(const float* position, float most) const;

  size_t bytes() const { return trends_.capacity() * sizeof(Trend) + marks_.capacity() + below_.capacity(); }
  static constexpr size_t kBytesPerPoint = sizeof(Trend) + 2;

 private:
  bool MarkNode(size_t node, size_t first_leaf, size_t leaves);
  void Descend(size_t node, size_t first_leaf, size_t leaves, const float* position, float& nearest) const;

  const SpatialIndex& index_;
  std::vector<Trend> trends_;   // by place
  std::vector<uint8_t> marks_;  // by place: whether the point lies beside an edge
  std::atomic<size_t> rough_count_ = 0, edge_count_ = 0;
  std::vector<uint8_t> below_;  // by node: whether a point below it lies beside an edge
};

}  // namespace curvd
