// What others make of positions without normals.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace curvd::bench {

// x y z of each, of unit length; of any sign unless they were oriented. NaN where there is none.
using PackedNormals = std::vector<float>;

// One library, as far as this program was built with it. Each runs on all threads that OpenMP has.
struct NormalPeer {
  const char* name;
  // Normals of the planes of least squares of k neighbors.
  PackedNormals (*estimate)(const std::vector<float>& positions, int k);
  // The same, turned to agree with those of k neighbors along a spanning tree; null: the library cannot.
  PackedNormals (*orient)(const std::vector<float>& positions, int k);
  // The same, turned to a viewpoint; null: the library cannot.
  PackedNormals (*face)(const std::vector<float>& positions, int k, const float* viewpoint);
};

// PCL and Open3D, if they were there when this program was built.
std::vector<NormalPeer> NormalPeers();

}  // namespace curvd::bench
