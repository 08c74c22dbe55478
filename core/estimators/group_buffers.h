// What the kernels keep between their steps. Internal to core/estimators/group_estimator.cc and core/kernels.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/scratch_array.h"
#include "core/estimators/delaunay/umbrella_triangles.h"
#include "core/estimators/fits/fit_buffers.h"
#include "core/estimators/group_estimator.h"
#include "core/estimators/hexagram/point_rows.h"
#include "core/index/spatial_index.h"
#include "core/search/kth_neighbor.h"
#include "core/search/leaf_list.h"

namespace curvd {

// A vector quantity of each point of a group.
struct alignas(64) GroupVectors {
  float x[SpatialIndex::kGroupPoints];
  float y[SpatialIndex::kGroupPoints];
  float z[SpatialIndex::kGroupPoints];

  void Set(size_t i, const float* v) {
    x[i] = v[0];
    y[i] = v[1];
    z[i] = v[2];
  }
};
using GroupScalars = float[SpatialIndex::kGroupPoints];

// Corrected measures of a neighborhood, of lengths in units of the index; `tensor` in the tangent frame.
struct alignas(64) GroupMeasures {
  GroupScalars area;
  GroupScalars mean;
  GroupScalars gaussian;
  GroupScalars tensor_uu;
  GroupScalars tensor_uv;  // symmetric part
  GroupScalars tensor_vv;
};

// The neighbors of one query in tree order: offsets from it, and normals.
struct NeighborArrays {
  ScratchArray<float> dx, dy, dz;
  ScratchArray<float> nx, ny, nz;
  size_t count = 0;
  float normal_sum[3] = {};

  // Room for `size` neighbors and one vector more.
  void Reserve(size_t size) {
    for (auto* array : {&dx, &dy, &dz, &nx, &ny, &nz}) array->Reserve(size + 16);
  }
};

// Corners of one hexagram of each point, as sums over neighbors: their offsets from the point and their number, and
// their normals less the point's own and nothing.
struct Hexagram {
  alignas(64) float offset[6][SpatialIndex::kGroupPoints][4];
  alignas(64) float normal[6][SpatialIndex::kGroupPoints][4];

  // A hexagram without neighbors: all corners at the point.
  void Clear(size_t i) {
    for (int s = 0; s < 6; ++s) {
      std::fill_n(offset[s][i], 4, 0.0f);
      std::fill_n(normal[s][i], 4, 0.0f);
    }
  }
};

// The points of one leaf relative to a center, and their squared distances from it.
struct alignas(64) CenteredLeaf {
  float x[SpatialIndex::kLeafSize];
  float y[SpatialIndex::kLeafSize];
  float z[SpatialIndex::kLeafSize];
  float squared_norm[SpatialIndex::kLeafSize];
};

struct GroupScratch::Buffers {
  LeafList leaves;                        // near the group
  LeafList own_leaves;                    // near one query, or near the targets of one corner of a leaf's points
  LeafList corner_leaves;                 // of `leaves`, those near the targets of one corner
  ScratchArray<CenteredLeaf> centered;    // the leaves that were listed for the targets of one corner
  ScratchArray<uint32_t> near;            // leaves that meet one query's ball; for corners, their places in a list
  ScratchArray<float> squared_distances;  // of all points of `near`
  ScratchArray<float> inner_distances;    // those within the search radius, padded with infinity
  ScratchArray<uint32_t> near_positions;  // in the list that was searched, of each of `near`
  size_t near_count = 0;                  // leaves of `near`
  NeighborRank last_rank{};               // the neighbors are the points of `near` of at most this rank
  NeighborArrays neighbors;
  ScratchArray<uint32_t> shuffle;  // independent triangles
  UmbrellaTriangles triangles;     // Delaunay
  PointRows rows;                  // averages over sectors: of the leaves of the list
  ScratchArray<int32_t> steps;     // averages over sectors: the neighbors, and where they lie
  std::vector<NeighborRank> heap;
  std::vector<int32_t> tied_ids;
  float reach_hint = 0.0f;  // largest neighborhood radius of the last group
  // Within how much of each corner's last targets there was a point: squared, in units of squared spacing. In the
  // plane, one hole in 150 of a random cloud is larger than 5.
  float target_reach[6] = {5, 5, 5, 5, 5, 5};

  std::array<uint64_t, kPointStatusEnd> status_counts{};  // of all points written

  // Of the points of the group.
  size_t size = 0;
  int32_t id[SpatialIndex::kGroupPoints];
  uint64_t seed[SpatialIndex::kGroupPoints];
  size_t slot[SpatialIndex::kGroupPoints];
  PointStatus status[SpatialIndex::kGroupPoints];
  GroupVectors query;            // the point
  GroupVectors normal;           // the point's own
  GroupScalars neighbor_count;   // of the search
  GroupScalars squared_radius;   // that the search came to
  GroupVectors normal_sum;       // over the neighbors
  GroupVectors u, v;             // tangent frame
  alignas(64) GroupScalars rho;  // radius of the figure, > 0
  GroupScalars squared_spacing;  // the squared radius that holds one point of an even surface
  GroupScalars radius;           // of the neighborhood, in the index's unit
  Hexagram hexagrams[kMaxRotations];
  GroupMeasures measures;
  std::unique_ptr<FitBuffers> fits;  // once an estimator fits surfaces
};

}  // namespace curvd
