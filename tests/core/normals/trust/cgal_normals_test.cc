// Whether normals that CGAL's packages make are known again.
#include <CGAL/Simple_cartesian.h>
#include <CGAL/jet_estimate_normals.h>
#include <CGAL/pca_estimate_normals.h>
#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "core/normals/trust/jet_probe.h"
#include "core/normals/trust/plane_probe.h"
#include "tests/core/normals/trust/probed_clouds.h"

namespace curvd::testing {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using PointWithNormal = std::pair<Kernel::Point_3, Kernel::Vector_3>;

template <typename Make>
TestPoints WithNormalsOf(TestPoints points, const Make& make) {
  std::vector<PointWithNormal> cgal;
  for (const auto& p : points.positions) cgal.emplace_back(Kernel::Point_3(p[0], p[1], p[2]), Kernel::Vector_3());
  make(cgal, CGAL::parameters::point_map(CGAL::First_of_pair_property_map<PointWithNormal>())
                 .normal_map(CGAL::Second_of_pair_property_map<PointWithNormal>()));
  for (size_t i = 0; i < points.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) points.normals[i][axis] = static_cast<float>(cgal[i].second[axis]);
  }
  return points;
}

// CGAL counts the neighbors without the point itself.
TEST(CgalNormalsTest, PlanesAreKnownAgain) {
  const TestPoints torus = WithNormalsOf(TorusWithNoise(0.1), [](auto& points, const auto& parameters) {
    CGAL::pca_estimate_normals<CGAL::Sequential_tag>(points, 18, parameters);
  });
  const auto found = Probed<PlaneProbe>(torus, 10'000, false);
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(ProbedCount(*found), 19u);
}

TEST(CgalNormalsTest, JetsAreKnownAgain) {
  const TestPoints torus = WithNormalsOf(TorusWithNoise(0.1), [](auto& points, const auto& parameters) {
    CGAL::jet_estimate_normals<CGAL::Sequential_tag>(points, 30, parameters);
  });
  const auto found = Probed<JetProbe>(torus, 10'000, false);
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(found->method, NormalMethod::kJet2);
  EXPECT_EQ(ProbedCount(*found), 31u);
}

}  // namespace
}  // namespace curvd::testing
