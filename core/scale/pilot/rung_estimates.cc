#include "core/scale/pilot/rung_estimates.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "Eigen/Geometry"
#include "core/base/halves.h"
#include "core/scale/line_distance.h"
#include "core/scale/pilot/distance_order.h"
#include "core/scale/pilot/neighbor_copies.h"
#include "core/scale/pilot/pilot_fits.h"
#include "core/scale/pilot/pilot_sums.h"
#include "core/scale/shapes/sphere_shape.h"

namespace curvd {
namespace {

using Eigen::Vector3d;

// Neighbors beyond this share of the squared radius are at the rim.
constexpr float kRim = 1.0f - 1e-6f;
// Neighbors whose normals make the frame.
constexpr size_t kFrameCount = 32;

// Rows are the axes of the frame; the last is the mean of the nearest normals. Zero if they cancel out.
Eigen::Matrix3d FrameOf(const PilotScratch& s) {
  const NeighborArrays& n = s.neighbors;
  Vector3d normal = Vector3d::Zero();
  for (size_t k = 0; k < std::min(kFrameCount, n.count); ++k) {
    const uint32_t j = s.order[k];
    normal += Vector3d(n.nx[j], n.ny[j], n.nz[j]);
  }
  Eigen::Matrix3d frame = Eigen::Matrix3d::Zero();
  if (!(normal.norm() > std::numeric_limits<float>::epsilon())) return frame;  // NaN included
  frame.row(2) = normal.normalized();
  frame.row(0) = frame.row(2).unitOrthogonal();
  frame.row(1) = frame.row(2).cross(frame.row(0));
  return frame;
}

void SetLine(const PointLine& line, const Eigen::Matrix3d& frame, PilotPoint& point) {
  point.line_distance = static_cast<float>(line.distance);
  const Vector3d along = frame * Vector3d(line.direction.data());
  const double squared = along.x() * along.x() + along.y() * along.y();
  if (!(squared > 0.0)) return;
  point.line = {static_cast<float>((along.x() * along.x() - along.y() * along.y()) / squared),
                static_cast<float>(2.0 * along.x() * along.y() / squared)};
}

PilotNeighbor NeighborInFrame(const NeighborArrays& n, uint32_t j, const Eigen::Matrix3d& frame, double unit) {
  const Vector3d offset = frame * (unit * Vector3d(n.dx[j], n.dy[j], n.dz[j]));
  const Vector3d normal = frame * Vector3d(n.nx[j], n.ny[j], n.nz[j]);
  return {{offset.x(), offset.y(), offset.z()}, {normal.x(), normal.y(), normal.z()}};
}

// One half of the neighbors. Finish adds those to the sums that were not yet added.
struct PilotHalf {
  PilotSums sums;
  SphereMoments spheres;
  PilotBatch batch;
  size_t distinct = 0;  // neighbors that are no copies

  void Add(const PilotNeighbor& neighbor, bool with_sextic, bool with_spheres) {
    if (batch.is_full()) Finish(with_sextic, with_spheres);
    batch.Add(neighbor);
  }
  void Finish(bool with_sextic, bool with_spheres) {
    if (with_sextic) {
      sums.Add(batch);
    } else {
      sums.AddWithoutSextic(batch);
    }
    if (with_spheres) spheres.Add(batch);
    batch.count = 0;
  }
};

// Where an estimate goes, of curvature in units of `unit`.
void Store(const TangentShape& shape, double unit, size_t method, size_t rung, PilotPoint::Part part,
           PilotPoint& point) {
  point.mean[method][rung][part] = static_cast<float>(shape.mean * unit);
  point.difference[method][rung][part] = static_cast<float>(shape.difference * unit);
  point.twist[method][rung][part] = static_cast<float>(shape.twist * unit);
}

void StoreSlopes(const std::array<TangentShape, 2>& slopes, double squared_unit, std::array<float, 6>& out) {
  size_t place = 0;
  for (const TangentShape& slope : slopes) {
    for (const double component : {slope.mean, slope.difference, slope.twist}) {
      out[place++] = static_cast<float>(component * squared_unit);
    }
  }
}

// Neighborhoods of one point, whole ones and halves, which are fitted several at a time.
class RungEstimates {
 public:
  // Curvature is in units of `unit`.
  RungEstimates(double unit, const MethodSet& methods, PilotPoint& point)
      : unit_(unit), point_(point), fitter_(methods) {}

  // The sphere of a neighborhood, of which `rim` are at its radius.
  void AddSphere(const SphereMoments& moments, std::span<const PilotNeighbor> rim, size_t distinct, double radius,
                 size_t rung, PilotPoint::Part part) {
    const auto shape = SphereShapeOf(moments, rim, static_cast<double>(distinct), radius);
    if (shape.has_value()) Store(*shape, unit_, kSphereMethod, rung, part, point_);
  }

  // `distinct` of the neighbors are no copies.
  void Add(const PilotSums& sums, size_t distinct, double radius, size_t rung, PilotPoint::Part part) {
    if (const auto hexagrams = sums.HexagramEstimate()) {
      Store(hexagrams->shape, unit_, kHexagramMethod, rung, part, point_);
      if (part == PilotPoint::kAll) point_.steepest[rung] = static_cast<float>(hexagrams->steepest * unit_);
    }
    places_[fitter_.size()] = {rung, part};
    fitter_.Add(sums, static_cast<double>(distinct), radius);
    if (fitter_.size() == PilotFitter::kMost) Finish();
  }

  // Fits those that are left.
  void Finish() {
    const size_t size = fitter_.size();
    if (size == 0) return;
    const auto fits = fitter_.Fit();
    for (size_t i = 0; i < size; ++i) Take(fits[i], places_[i].rung, places_[i].part);
  }

 private:
  struct Place {
    size_t rung;
    PilotPoint::Part part;
  };

  void Take(const PilotFits& fits, size_t rung, PilotPoint::Part part) {
    const auto store = [&](const TangentShape& shape, size_t method) {
      Store(shape, unit_, method, rung, part, point_);
    };
    if (fits.regression.has_value()) {
      store(fits.regression->shape, kRegressionMethod);
      StoreSlopes(fits.regression->slope, unit_ * unit_, point_.slope[rung][part]);
      if (part == PilotPoint::kAll) point_.normal_residual[rung] = static_cast<float>(fits.regression->residual);
    }
    if (fits.quadratic_regression.has_value()) store(*fits.quadratic_regression, kQuadraticRegressionMethod);
    if (fits.linear_regression.has_value()) store(*fits.linear_regression, kLinearRegressionMethod);
    if (fits.quartic.has_value()) {
      store(fits.quartic->shape, kQuarticMethod);
      if (part == PilotPoint::kAll) point_.residual[rung] = static_cast<float>(fits.quartic->residual / unit_);
    }
    if (fits.quadric.has_value()) store(fits.quadric->shape, kQuadricMethod);
    if (fits.sextic.has_value()) store(fits.sextic->shape, kSexticMethod);
  }

  const double unit_;
  PilotPoint& point_;
  PilotFitter fitter_;
  std::array<Place, PilotFitter::kMost> places_;
};

// Estimates the spheres of a rung, of `count` neighbors, and of its halves.
void AddSpheres(const std::array<PilotHalf, 2>& halves, size_t rung, size_t count, const Eigen::Matrix3d& frame,
                double unit, RungEstimates& estimates, PilotScratch& s) {
  const auto half_of = [&s](uint32_t j) { return static_cast<size_t>(HalfOf(FirstOfCopies(s.ids[j]))); };
  const float farthest = s.squared[s.order[count - 1]];
  std::array<std::vector<PilotNeighbor>, PilotPoint::kParts>& rims = s.rims;
  for (std::vector<PilotNeighbor>& rim : rims) rim.clear();
  for (size_t k = count;
       k > count - std::min(count, PilotScratch::kMostAtRim) && s.squared[s.order[k - 1]] >= kRim * farthest; --k) {
    const PilotNeighbor neighbor = NeighborInFrame(s.neighbors, s.order[k - 1], frame, unit);
    rims[PilotPoint::kAll].push_back(neighbor);
    rims[half_of(s.order[k - 1]) == 0 ? PilotPoint::kEven : PilotPoint::kOdd].push_back(neighbor);
  }
  const double radius = unit * std::sqrt(double{farthest});
  SphereMoments all = halves[0].spheres;
  all += halves[1].spheres;
  const size_t distinct = halves[0].distinct + halves[1].distinct;
  estimates.AddSphere(all, rims[PilotPoint::kAll], distinct, radius, rung, PilotPoint::kAll);
  estimates.AddSphere(halves[0].spheres, rims[PilotPoint::kEven], halves[0].distinct, radius, rung, PilotPoint::kEven);
  estimates.AddSphere(halves[1].spheres, rims[PilotPoint::kOdd], halves[1].distinct, radius, rung, PilotPoint::kOdd);
}

}  // namespace

void EstimateRungs(size_t rung_count, const MethodSet& methods, PilotScratch& s, PilotPoint& point) {
  OrderByDistance(s);
  MarkCopies(s);
  const Eigen::Matrix3d frame = FrameOf(s);
  const double farthest = s.squared[s.order[kScaleRungs[rung_count - 1] - 1]];
  if (frame.isZero() || !(farthest > 0.0)) return;
  const double unit = 1.0 / std::sqrt(farthest);
  std::array<PilotHalf, 2> halves;
  const auto axis = [&](int row) { return std::array{frame(row, 0), frame(row, 1), frame(row, 2)}; };
  SetLine(LineOf(s, axis(0), axis(1)), frame, point);
  RungEstimates estimates(unit, methods, point);
  const bool with_spheres = methods[kSphereMethod];
  size_t next = 0;
  for (size_t rung = 0; rung < rung_count; ++rung) {
    const bool with_sextic = methods[kSexticMethod] && kScaleRungs[rung] <= kMostSexticCount;
    for (; next < kScaleRungs[rung]; ++next) {
      const uint32_t j = s.order[next];
      // Copies share their noise: they belong to one half.
      PilotHalf& half = halves[static_cast<size_t>(HalfOf(FirstOfCopies(s.ids[j])))];
      half.Add(NeighborInFrame(s.neighbors, j, frame, unit), with_sextic, with_spheres);
      half.distinct += IsCopy(s.ids[j]) ? 0 : 1;
    }
    for (PilotHalf& half : halves) half.Finish(with_sextic, with_spheres);
    const double radius = unit * std::sqrt(double{s.squared[s.order[next - 1]]});
    point.radius[rung] = static_cast<float>(radius / unit);
    if (!(radius > 0.0)) continue;
    PilotSums all = halves[0].sums;
    all += halves[1].sums;
    if (all.LieAlongLine()) continue;
    estimates.Add(all, halves[0].distinct + halves[1].distinct, radius, rung, PilotPoint::kAll);
    estimates.Add(halves[0].sums, halves[0].distinct, radius, rung, PilotPoint::kEven);
    estimates.Add(halves[1].sums, halves[1].distinct, radius, rung, PilotPoint::kOdd);
    if (with_spheres) AddSpheres(halves, rung, next, frame, unit, estimates, s);
  }
  estimates.Finish();
}

}  // namespace curvd
