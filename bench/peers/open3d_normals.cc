#include <open3d/geometry/KDTreeSearchParam.h>
#include <open3d/geometry/PointCloud.h>

#include "bench/peers/normal_peers.h"

namespace curvd::bench {
namespace {

open3d::geometry::PointCloud Estimated(const std::vector<float>& positions, int k) {
  open3d::geometry::PointCloud cloud;
  cloud.points_.reserve(positions.size() / 3);
  for (size_t i = 0; i < positions.size(); i += 3) {
    cloud.points_.emplace_back(positions[i], positions[i + 1], positions[i + 2]);
  }
  cloud.EstimateNormals(open3d::geometry::KDTreeSearchParamKNN(k));
  return cloud;
}

PackedNormals Pack(const open3d::geometry::PointCloud& cloud) {
  PackedNormals packed;
  packed.reserve(3 * cloud.normals_.size());
  for (const Eigen::Vector3d& normal : cloud.normals_) {
    for (int axis = 0; axis < 3; ++axis) packed.push_back(static_cast<float>(normal[axis]));
  }
  return packed;
}

PackedNormals Estimate(const std::vector<float>& positions, int k) { return Pack(Estimated(positions, k)); }

PackedNormals Orient(const std::vector<float>& positions, int k) {
  open3d::geometry::PointCloud cloud = Estimated(positions, k);
  cloud.OrientNormalsConsistentTangentPlane(static_cast<size_t>(k));
  return Pack(cloud);
}

}  // namespace

NormalPeer Open3dNormals() { return {"Open3D", Estimate, Orient, nullptr}; }

}  // namespace curvd::bench
