// Which points of a cloud lie beside a sharp edge, and how far others are from the nearest of them.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/index/spatial_index.h"
#include "core/scale/edges/normal_trend.h"

namespace curvd {

// What noise makes of normals, as far as it is known: their own, along each tangent, and that of positions, in the
// index's unit, which moves a point to where the normal is another one.
struct EdgeNoise {
  double of_normals, of_positions;
};

// Usage: SetTrend of points, of which all others are smooth; MarkGroup of every group; Finish; then ask. The first two
// are thread-safe for distinct groups, and const methods are.
class EdgeMarks {
 private:
  struct Trend {
    float roughness, slope;
  };

 public:
  // `index` outlives the object. May throw std::bad_alloc.
  explicit EdgeMarks(const SpatialIndex& index);

  // How the normals around a point change.
  void SetTrend(size_t place, const NormalTrend& trend) {
    trends_[place] = {static_cast<float>(trend.roughness), static_cast<float>(trend.slope)};
  }
  float RoughnessAt(size_t place) const { return trends_[place].roughness; }
  // The noise of the normals around a point.
  double NoiseAt(size_t place, const EdgeNoise& noise) const;
  // Whether the normals around it are rougher than noise can make them.
  bool IsRough(size_t place, const EdgeNoise& noise) const;
  // Whether it is nearly that, so that others around it may be.
  bool MayBeRough(size_t place, const EdgeNoise& noise) const;

  // Marks the points of a group whose bits in `has_faces`, that of the first one the lowest, are set: those of its
  // rough points, which are so many, whose normals are of two or three faces. One to three such points of a group are
  // chance, and not marked.
  void MarkGroup(size_t group, size_t rough_count, uint64_t has_faces);
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
  double SquaredNoiseAt(size_t place, const EdgeNoise& noise) const;
  // Whether normals are rougher than this share of what noise can make them.
  bool IsRougher(size_t place, double share, const EdgeNoise& noise) const;
  bool MarkNode(size_t node, size_t first_leaf, size_t leaves);
  void Descend(size_t node, size_t first_leaf, size_t leaves, const float* position, float& nearest) const;

  const SpatialIndex& index_;
  std::vector<Trend> trends_;   // by place
  std::vector<uint8_t> marks_;  // by place: whether the point lies beside an edge
  std::atomic<size_t> rough_count_ = 0, edge_count_ = 0;
  std::vector<uint8_t> below_;  // by node: whether a point below it lies beside an edge
};

}  // namespace curvd
