#include <pcl/features/normal_3d_omp.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>

#include "bench/peers/normal_peers.h"

namespace curvd::bench {
namespace {

PackedNormals Estimate(const std::vector<float>& positions, int k, const float* viewpoint) {
  const auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  cloud->reserve(positions.size() / 3);
  for (size_t i = 0; i < positions.size(); i += 3) {
    cloud->push_back(pcl::PointXYZ(positions[i], positions[i + 1], positions[i + 2]));
  }
  pcl::NormalEstimationOMP<pcl::PointXYZ, pcl::Normal> estimation(0);  // all threads
  estimation.setInputCloud(cloud);
  estimation.setSearchMethod(pcl::make_shared<pcl::search::KdTree<pcl::PointXYZ>>());
  estimation.setKSearch(k);
  estimation.setViewPoint(viewpoint[0], viewpoint[1], viewpoint[2]);
  pcl::PointCloud<pcl::Normal> normals;
  estimation.compute(normals);
  PackedNormals packed;
  packed.reserve(positions.size());
  for (const pcl::Normal& normal : normals) {
    packed.insert(packed.end(), {normal.normal_x, normal.normal_y, normal.normal_z});
  }
  return packed;
}

PackedNormals EstimateAnySide(const std::vector<float>& positions, int k) {
  constexpr float kOrigin[3] = {0.0f, 0.0f, 0.0f};
  return Estimate(positions, k, kOrigin);
}

}  // namespace

NormalPeer PclNormals() { return {"PCL", EstimateAnySide, nullptr, Estimate}; }

}  // namespace curvd::bench
