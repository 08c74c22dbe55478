#include "bench/peers/normal_peers.h"

namespace curvd::bench {

NormalPeer PclNormals();
NormalPeer Open3dNormals();

std::vector<NormalPeer> NormalPeers() {
  std::vector<NormalPeer> peers;
#ifdef BENCH_HAS_PCL
  peers.push_back(PclNormals());
#endif
#ifdef BENCH_HAS_OPEN3D
  peers.push_back(Open3dNormals());
#endif
  return peers;
}

}  // namespace curvd::bench
