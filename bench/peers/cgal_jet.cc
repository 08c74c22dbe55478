#include <CGAL/Monge_via_jet_fitting.h>
#include <CGAL/Simple_cartesian.h>

#include "bench/peers/plain_peers.h"

namespace curvd::bench {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using JetFitting = CGAL::Monge_via_jet_fitting<Kernel>;

std::array<float, 3> Direction(const Kernel::Vector_3& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

}  // namespace

void RunCgalJet(const PeerCloud& cloud, const PeerNeighbors& neighbors, size_t degree, PointCurvature* out) {
  const auto triple = [](std::span<const double> triples, size_t i) { return &triples[3 * i]; };
  std::vector<Kernel::Point_3> points(neighbors.k);
  for (size_t i = 0; i < neighbors.size(); ++i) {
    const std::span<const uint32_t> around = neighbors.of(i);
    for (size_t j = 0; j < around.size(); ++j) {
      const double* p = triple(cloud.positions, around[j]);
      points[j] = Kernel::Point_3(p[0], p[1], p[2]);
    }
    JetFitting fitting;
    JetFitting::Monge_form monge = fitting(points.begin(), points.end(), degree, 2);
    const double* n = triple(cloud.normals, i);
    monge.comply_wrt_given_normal(Kernel::Vector_3(n[0], n[1], n[2]));
    // CGAL's curvature is that of the height along the normal: negative on a ball.
    const double k1 = -monge.principal_curvatures(0), k2 = -monge.principal_curvatures(1);
    PointCurvature& point = out[i];
    point.k1 = static_cast<float>(k1);
    point.k2 = static_cast<float>(k2);
    point.mean = static_cast<float>(0.5 * (k1 + k2));
    point.gaussian = static_cast<float>(k1 * k2);
    point.d1 = Direction(monge.maximal_principal_direction());
    point.d2 = Direction(monge.minimal_principal_direction());
    point.radius = static_cast<float>(neighbors.radii[i]);
    point.status = PointStatus::kOk;
  }
}

}  // namespace curvd::bench
