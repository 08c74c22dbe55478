// The K-th distance against nanoflann, on clouds too large for brute force.
#include <gtest/gtest.h>

#include <cmath>
#include <nanoflann.hpp>

#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

struct PointsAdaptor {
  const TestPoints& points;
  size_t kdtree_get_point_count() const { return points.size(); }
  double kdtree_get_pt(size_t i, size_t axis) const { return points.positions[i][axis]; }
  template <typename Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, PointsAdaptor>, PointsAdaptor, 3>;

TEST(NanoflannTest, RadiiAgreeOnEveryLayoutAndSeed) {
  for (Layout layout : kLayouts) {
    for (uint64_t seed = 10; seed < 14; ++seed) {
      const TestPoints points = RandomPoints(layout, 20'000, seed);
      const PointsAdaptor adaptor{points};
      Tree tree(3, adaptor, nanoflann::KDTreeSingleIndexAdaptorParams(10));
      tree.buildIndex();
      for (uint32_t k : {8u, 64u, 200u}) {
        EstimatorOptions options;
        options.neighborhood = NeighborCount{k};
        const EstimationResult result = MustEstimate(points.ToCloud(), options);
        std::vector<uint32_t> ids(k);
        std::vector<double> squared(k);
        for (size_t i = 0; i < points.size(); i += 97) {
          if (result.field.points[i].status != PointStatus::kOk) continue;
          const double query[3] = {points.positions[i][0], points.positions[i][1], points.positions[i][2]};
          tree.knnSearch(query, k, ids.data(), squared.data());
          const double expected = std::sqrt(squared.back());
          // Kernels round differences and squares to float: 1e-6 relative.
          ASSERT_NEAR(result.field.points[i].radius, expected, 1e-6 * expected)
              << LayoutName(layout) << " seed " << seed << " k " << k << " point " << i;
        }
      }
    }
  }
}

}  // namespace
}  // namespace curvd::testing
