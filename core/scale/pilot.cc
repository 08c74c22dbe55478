#include "core/scale/pilot.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <tuple>

#include "Eigen/Geometry"
#include "core/base/copies.h"
#include "core/scale/line_distance.h"
#include "core/scale/pilot_fits.h"
#include "core/scale/pilot_sums.h"
#include "core/scale/shapes/sphere_shape.h"

namespace curvd {
namespace {

using Eigen::Vector3d;

// A neighborhood of more than this share of the cloud is no neighborhood.
constexpr size_t kLargestShare = 3;
// Neighbors beyond this share of the squared radius are at the rim. More of them than this, which are hardly ever
// there, are left where they are.
constexpr float kRim = 1.0f - 1e-6f;
constexpr size_t kMostAtRim = 64;
// Neighbors whose normals make the frame.
constexpr size_t kFrameCount = 32;

// Sorts by the upper half, which is that of a float that is not negative: digit by digit, each of which keeps the order
// that the ones before have made.
void SortByFloats(std::vector<uint64_t>& keys, std::vector<uint64_t>& other) {
  constexpr int kDigitBits = 11, kFirstBit = 32, kDigits = 3;
  constexpr uint64_t kDigitMask = (uint64_t{1} << kDigitBits) - 1;
  other.resize(keys.size());
  for (int digit = 0; digit < kDigits; ++digit) {
    const int shift = kFirstBit + digit * kDigitBits;
    const auto digit_of = [shift](uint64_t key) { return static_cast<size_t>(key >> shift & kDigitMask); };
    std::array<uint32_t, kDigitMask + 1> places{};
    for (const uint64_t key : keys) ++places[digit_of(key)];
    std::exclusive_scan(places.begin(), places.end(), places.begin(), 0U);
    for (const uint64_t key : keys) other[places[digit_of(key)]++] = key;
    keys.swap(other);
  }
}

// Finds the copies among neighbors that are equally far away.
void MarkTiedCopies(std::span<const uint32_t> tied, PilotScratch& s) {
  const NeighborArrays& n = s.neighbors;
  const auto position = [&n](uint32_t j) { return std::tuple(n.dx[j], n.dy[j], n.dz[j]); };
  s.tied.assign(tied.begin(), tied.end());
  std::sort(s.tied.begin(), s.tied.end(), [&](uint32_t a, uint32_t b) {
    return std::tuple_cat(position(a), std::tuple(s.ids[a])) < std::tuple_cat(position(b), std::tuple(s.ids[b]));
  });
  for (size_t k = 1; k < s.tied.size(); ++k) {
    const uint32_t before = s.tied[k - 1], j = s.tied[k];
    if (position(before) == position(j)) s.ids[j] = ~FirstOfCopies(s.ids[before]);
  }
}

void MarkExactCopies(PilotScratch& s) {
  const std::span<const uint32_t> order = s.order;
  for (size_t first = 0; first < order.size();) {
    size_t last = first + 1;
    while (last < order.size() && s.squared[order[last]] == s.squared[order[first]]) ++last;
    if (last - first > 1) MarkTiedCopies(order.subspan(first, last - first), s);
    first = last;
  }
}

// Among so many of the nearest neighbors near copies are looked for first, and among so many before each in the order
// of distance.
constexpr size_t kLookedAt = 256, kMostBefore = 64;

// Calls visit(before, squared) for each neighbor before the k-th that may be as near to it as `most`, the last one
// first, until it returns true.
template <typename Visit>
void VisitNear(const PilotScratch& s, size_t k, float most, const Visit& visit) {
  const NeighborArrays& n = s.neighbors;
  const uint32_t j = s.order[k];
  const float least = std::sqrt(s.squared[j]) - most;
  for (size_t before = k; before > 0 && k - before < kMostBefore;) {
    const uint32_t i = s.order[--before];
    if (least > 0.0f && s.squared[i] < least * least) return;
    const float x = n.dx[i] - n.dx[j], y = n.dy[i] - n.dy[j], z = n.dz[i] - n.dz[j];
    if (visit(before, x * x + y * y + z * z)) return;
  }
}

void MarkNearCopies(PilotScratch& s) {
  const size_t looked_at = std::min(s.order.size(), kLookedAt);
  if (looked_at == 0) return;
  NearCopies copies(std::sqrt(s.squared[s.order[looked_at - 1]]), looked_at);
  if (!(copies.distance() > 0.0f)) return;
  for (size_t k = 1; k < looked_at; ++k) {
    VisitNear(s, k, copies.clearance(), [&](size_t, float squared) {
      copies.AddPair(squared);
      return false;
    });
  }
  if (!copies.Exist()) return;
  const float most = copies.distance() * copies.distance();
  for (size_t k = 1; k < s.order.size(); ++k) {
    int32_t& id = s.ids[s.order[k]];
    if (IsCopy(id)) continue;
    VisitNear(s, k, copies.distance(), [&](size_t before, float squared) {
      if (squared <= most) id = ~FirstOfCopies(s.ids[s.order[before]]);
      return squared <= most;
    });
  }
}

// Sets s.order to the neighbors by distance; equal distances go to the lower id. Sums must not depend on the order of
// the tree.
void OrderByDistance(PilotScratch& s) {
  const NeighborArrays& n = s.neighbors;
  s.squared.resize(n.count);
  s.keys.resize(n.count);
  for (size_t j = 0; j < n.count; ++j) {
    s.squared[j] = n.dx[j] * n.dx[j] + n.dy[j] * n.dy[j] + n.dz[j] * n.dz[j];
    s.keys[j] = uint64_t{std::bit_cast<uint32_t>(s.squared[j])} << 32 | j;
  }
  SortByFloats(s.keys, s.other_keys);
  s.order.resize(n.count);
  std::transform(s.keys.begin(), s.keys.end(), s.order.begin(),
                 [](uint64_t key) { return static_cast<uint32_t>(key); });
  for (auto first = s.order.begin(); first != s.order.end();) {
    const auto is_farther = [&](uint32_t j) { return s.squared[j] != s.squared[*first]; };
    const auto last = std::find_if(first + 1, s.order.end(), is_farther);
    if (last - first > 1) std::sort(first, last, [&](uint32_t a, uint32_t b) { return s.ids[a] < s.ids[b]; });
    first = last;
  }
}

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
  const auto half_of = [&s](uint32_t j) { return IsInEvenHalf(FirstOfCopies(s.ids[j])) ? 0 : 1; };
  const float farthest = s.squared[s.order[count - 1]];
  std::array<std::vector<PilotNeighbor>, PilotPoint::kParts>& rims = s.rims;
  for (std::vector<PilotNeighbor>& rim : rims) rim.clear();
  for (size_t k = count; k > count - std::min(count, kMostAtRim) && s.squared[s.order[k - 1]] >= kRim * farthest; --k) {
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

void MarkCopies(PilotScratch& s) {
  MarkExactCopies(s);
  MarkNearCopies(s);
}

size_t PilotScratch::bytes() const {
  return sizeof(*this) + search.bytes() + neighbors.bytes() + ids.bytes() + order.capacity() * sizeof(uint32_t) +
         (keys.capacity() + other_keys.capacity()) * sizeof(uint64_t) + squared.capacity() * sizeof(float) +
         normals.capacity() * sizeof(NeighborNormal) + tied.capacity() * sizeof(uint32_t) +
         (rims[0].capacity() + rims[1].capacity() + rims[2].capacity()) * sizeof(PilotNeighbor);
}

size_t PilotScratch::MostBytes(const EstimatorOptions& options, size_t point_count) {
  const size_t most = MostNeighbors(options, point_count);
  return sizeof(PilotScratch) + SearchScratchBytes(SearchSizes(options), point_count) +
         NeighborArrays::MostBytes(most) + ScratchArray<int32_t>::MostBytes(most + NeighborArrays::kPad) +
         most * (3 * sizeof(uint32_t) + sizeof(float) + 2 * sizeof(uint64_t) + 2 * sizeof(NeighborNormal)) +
         kMostAtRim * PilotPoint::kParts * sizeof(PilotNeighbor);
}

Pilot::Pilot(const SpatialIndex& index, uint32_t most_count) : index_(index) {
  const size_t points = index.point_count();
  const size_t most = std::min<size_t>(most_count, std::max<size_t>(points / kLargestShare, kScaleRungs[0]));
  while (rung_count_ < kRungCount && kScaleRungs[rung_count_] <= std::min(most, points)) ++rung_count_;
  if (rung_count_ > 0) KeepRungs(rung_count_);
}

void Pilot::KeepMethods(const MethodSet& methods) {
  for (size_t m = 0; m < kMethodCount; ++m) {
    const bool tells_noise = m == kHexagramMethod || m == kRegressionMethod || m == kQuarticMethod;
    methods_[m] = methods_[m] && (methods[m] || tells_noise);
  }
}

void Pilot::KeepRungs(size_t count) {
  rung_count_ = std::min(rung_count_, count);
  options_.neighborhood = NeighborCount{kScaleRungs[rung_count_ - 1]};
  plan_ = NeighborhoodPlan::Make(options_, index_);
}

absl::Status Pilot::SampleGroup(size_t group, Samples which, PilotScratch& scratch, std::span<PilotPoint> table) const {
  const size_t first = group * SpatialIndex::kGroupLeaves;
  const size_t last = std::min(first + SpatialIndex::kGroupLeaves, index_.leaf_count());
  bool is_sampled = false;
  for (size_t leaf = first; leaf < last; ++leaf) is_sampled = is_sampled || IsSampledNow(leaf, which);
  if (!is_sampled) return absl::OkStatus();
  scratch.most_work = std::numeric_limits<uint64_t>::max();  // the points are few
  scratch.first_point = 0;
  const auto leaf_of = [&](size_t i) { return static_cast<size_t>(scratch.points.place[i]) / SpatialIndex::kLeafSize; };
  // Where the points that are kept go in the table.
  std::array<size_t, SpatialIndex::kGroupPoints> places;
  std::array<size_t, SpatialIndex::kGroupLeaves> kept_of_leaf{};
  size_t kept = 0;
  const auto is_sampled_point = [&](size_t i) {
    const size_t leaf = leaf_of(i);
    size_t& rank = kept_of_leaf[leaf - first];
    if (rank == samples_of_leaf() || !IsSampledNow(leaf, which)) return false;
    places[kept++] = PlaceOf(leaf, which) + rank++;
    return true;
  };
  return CollectNeighbors(index_, plan_, group, CollectedPoints::kQueries, scratch, is_sampled_point, [&](size_t i) {
    float position[3];
    scratch.points.query.Get(i, position);
    PilotPoint& point = table[places[i]];
    point = PilotPoint({position[0], position[1], position[2]});
    EstimateRungs(rung_count_, methods_, scratch, point);
  });
}

void EstimateRungs(size_t rung_count, const MethodSet& methods, PilotScratch& s, PilotPoint& point) {
  OrderByDistance(s);
  MarkCopies(s);
  const Eigen::Matrix3d frame = FrameOf(s);
  const double farthest = s.squared[s.order[kScaleRungs[rung_count - 1] - 1]];
  if (frame.isZero() || !(farthest > 0.0)) return;
  const double unit = 1.0 / std::sqrt(farthest);
  std::array<PilotHalf, 2> halves;
  SetLine(LineOf(s), frame, point);
  RungEstimates estimates(unit, methods, point);
  const bool with_spheres = methods[kSphereMethod];
  size_t next = 0;
  for (size_t rung = 0; rung < rung_count; ++rung) {
    const bool with_sextic = methods[kSexticMethod] && kScaleRungs[rung] <= kMostSexticCount;
    for (; next < kScaleRungs[rung]; ++next) {
      const uint32_t j = s.order[next];
      // Copies share their noise: they belong to one half.
      PilotHalf& half = halves[IsInEvenHalf(FirstOfCopies(s.ids[j])) ? 0 : 1];
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
