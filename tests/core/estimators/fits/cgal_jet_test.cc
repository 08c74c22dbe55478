// Jets against CGAL's Monge_via_jet_fitting, in doubles, on each instruction set that this machine has.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "CGAL/Monge_via_jet_fitting.h"
#include "CGAL/Simple_cartesian.h"
#include "core/estimators/fits/fit_scratch.h"
#include "core/estimators/strategies.h"
#include "core/index/index_builder.h"
#include "tests/core/instruction_sets.h"
#include "tests/core/reference_estimator.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using JetFitting = CGAL::Monge_via_jet_fitting<Kernel>;

using CgalJetTest = InstructionSetTest;

INSTANTIATE_TEST_SUITE_P(EachInstructionSet, CgalJetTest, InstructionSets(), InstructionSetName);

struct CgalJet {
  double k1 = 0.0, k2 = 0.0;  // of outward normals; k1 <= k2
  Kernel::Vector_3 d2;        // of k2
  double condition = 0.0;
};

// Offsets are rounded to float as the search stores them; lengths in units of rho.
CgalJet FitWithCgal(const TestPoints& points, size_t i, size_t k, size_t degree, double rho) {
  std::vector<Kernel::Point_3> offsets;  // the query point first
  for (const int id : NearestIds(points, i, k)) {
    const auto &p = points.positions[static_cast<size_t>(id)], &q = points.positions[i];
    offsets.emplace_back((p[0] - q[0]) / rho, (p[1] - q[1]) / rho, (p[2] - q[2]) / rho);
  }
  JetFitting fitting;
  JetFitting::Monge_form monge = fitting(offsets.begin(), offsets.end(), degree, 2);
  const auto& n = points.normals[i];
  monge.comply_wrt_given_normal({n[0], n[1], n[2]});
  // CGAL's curvature is that of the height over the normal: negative on a ball. Its larger one is our smaller.
  return {-monge.principal_curvatures(0), -monge.principal_curvatures(1), monge.minimal_principal_direction(),
          fitting.condition_number()};
}

SpatialIndex BuildIndex(Cloud cloud) {
  IndexBuilder builder(std::move(cloud));
  EXPECT_TRUE(builder.Start().ok());
  while (builder.block_count() > 0) {
    for (size_t block = 0; block < builder.block_count(); ++block) builder.RunBlock(block);
    builder.EndPhase();
  }
  std::vector<IndexBuilder::Part> open = {builder.root()};
  while (!open.empty()) {
    const IndexBuilder::Part part = open.back();
    open.pop_back();
    builder.Build(part, [&](const IndexBuilder::Part& half) { open.push_back(half); });
  }
  return builder.Take();
}

// Well posed: singular values within four decades, so that normal equations lose at most eight digits. The quanta of
// sums that do not depend on their order are up to 2^-44 of the largest addend (200 neighbors, one lane), which leaves
// this.
constexpr double kRelative = 5e-7;

// Compares the shapes of every point of every seventh group before they are rounded to float.
void ExpectNearCgal(const TestPoints& points, uint32_t k, uint32_t degree) {
  EstimatorOptions options;
  options.estimator = "jet";
  options.jet_degree = degree;
  options.neighborhood = NeighborCount{k};
  const SpatialIndex index = BuildIndex(points.ToCloud());
  std::vector<PointCurvature> field(points.size());
  const std::unique_ptr<StrategyRun> run = FindStrategy("jet")->start(options, index, field.data());
  const std::unique_ptr<WorkerScratch> scratch = run->MakeScratch();
  const auto& jets = dynamic_cast<const JetScratch&>(*scratch);
  const double scale = std::ldexp(1.0, index.scale_exponent());
  size_t compared = 0, refused = 0, seen = 0;
  for (size_t group = 0; group < index.group_count(); group += 7) {
    ASSERT_TRUE(run->Phases().back().run(group, *scratch).ok());
    for (size_t j = 0; j < jets.points.size; ++j, ++seen) {
      const double rho = jets.frames.rho[j] / scale;
      const CgalJet cgal = FitWithCgal(points, static_cast<size_t>(jets.points.rank[j]), k, degree, rho);
      if (jets.points.status[j] != PointStatus::kOk) {
        ++refused;
        continue;
      }
      if (cgal.condition > 1e4) continue;
      ++compared;
      const double largest = std::max(std::abs(cgal.k1), std::abs(cgal.k2));
      const GroupShapes& shapes = jets.shapes;
      ASSERT_NEAR(shapes.mean[j] - shapes.half_difference[j], cgal.k1, kRelative * largest) << "degree " << degree;
      ASSERT_NEAR(shapes.mean[j] + shapes.half_difference[j], cgal.k2, kRelative * largest) << "degree " << degree;
      ASSERT_NEAR(shapes.gaussian[j], cgal.k1 * cgal.k2, kRelative * largest * largest) << "degree " << degree;
      // A direction is as exact as its curvature is apart from the other.
      const double across = shapes.d1.x[j] * cgal.d2.x() + shapes.d1.y[j] * cgal.d2.y() + shapes.d1.z[j] * cgal.d2.z();
      ASSERT_LT(std::abs(across) * (cgal.k2 - cgal.k1), kRelative * largest) << "degree " << degree;
    }
  }
  EXPECT_GT(compared, seen * 4 / 5);
  // By chance few neighbors lie near a curve, which fixes no polynomial.
  EXPECT_LE(refused, seen / 100);
}

TEST_P(CgalJetTest, MongeFormsAgreeOnWellPosedNeighborhoods) {
  for (const uint32_t degree : {2u, 3u, 4u}) {
    for (const uint32_t k : {20u, 50u, 200u}) {
      ExpectNearCgal(Waves(3000, 0.0, degree), k, degree);
      ExpectNearCgal(Waves(3000, 0.01, degree), k, degree);
    }
  }
  // Callers cannot ask for these; the automatic choice takes them.
  for (const uint32_t k : {100u, 200u}) ExpectNearCgal(Waves(3000, 0.0, k), k, kMaxFittedDegree);
}

}  // namespace
}  // namespace curvd::testing
