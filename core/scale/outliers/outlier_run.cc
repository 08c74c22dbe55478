#include "core/scale/outliers/outlier_run.h"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "core/base/quantile.h"
#include "core/scale/automatic_options.h"

namespace curvd {
namespace {

// So many of the nearest neighbors that have a result, and are no outliers themselves, judge a point: that many are on
// either side of an edge, or of a thin part.
constexpr size_t kJudges = 24;
constexpr size_t kFewestJudges = 8;
// The nearest of them, as many as the fewest, settle a point that is so much like them that no rule below minds how
// much: deviations of less than kLeastMedian spacings are as good as 0, and so are angles of less than 30 degrees, a
// third of the least that an outlier has. Nearly all points of an exact cloud are settled so.
constexpr float kSettledCosine = 0.866f;
// So many neighbors are looked for first: with some room for those that may not judge.
constexpr size_t kNearestFew = kFewestJudges + 4;
// So many must bear a point out: one or two may be outliers like it.
constexpr size_t kFewestWitnesses = 3;
// The distance of this neighbor, from 0 on, and of how many spacings it is the radius on an even surface.
constexpr size_t kSpacingNeighbor = 6;
constexpr float kSpacingsToIt = 1.5f;

// An outlier deviates by more than this many times the median of the points around it, which is at least this part of
// their spacing where these are exact; by this part of the spacing; and by this many times what nine in ten points of
// the cloud stay below. Noise that is normal stays below 14 medians in 20,000 points.
constexpr float kTimesMedian = 15.0f;
constexpr float kLeastMedian = 1e-3f;
constexpr float kLeastOfSpacing = 0.2f, kLeastOfSpacingAgain = 0.03f;
constexpr double kTimesUsual = 10.0;
constexpr double kShareOfUsualValues = 0.9;
constexpr size_t kMostSampled = 4096;
// And by more than this part of the spacing, or this many times what two in three of its neighbors stay below: where a
// third of them deviates like it, they are a noisy part, whatever those across its border do.
constexpr float kFarInSpacings = 1.0f;
constexpr float kTimesNeighbors = 7.0f;
constexpr size_t kNeighborsAbove = 3;
// The normal of an outlier has a larger angle than this with those of all its neighbors but two, and so many times that
// which nine in ten points stay below; or this one.
constexpr double kLonelyAngle = 100.0 * std::numbers::pi / 180.0, kTimesUsualAngle = 3.0;
constexpr double kMostLonelyAngle = 120.0 * std::numbers::pi / 180.0;
constexpr size_t kMostShareInverse = 4;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();
// What is larger, or not a number since the bends of a point that is very far away overflow, counts as this.
constexpr float kMostHeight = std::numeric_limits<float>::max();

using Vector = std::array<float, 3>;

template <typename Leaf>
Vector VectorAt(const Leaf& leaf, size_t place) {
  const size_t i = place % SpatialIndex::kLeafSize;
  return {leaf.x[i], leaf.y[i], leaf.z[i]};
}

// Vectors of the judges of a point, by component, for loops that compilers make vector code of.
struct JudgeVectors {
  std::array<float, kJudges> x, y, z;

  void Set(size_t i, const Vector& vector) {
    x[i] = vector[0];
    y[i] = vector[1];
    z[i] = vector[2];
  }
  float DotAt(size_t i, const JudgeVectors& other) const {
    return x[i] * other.x[i] + y[i] * other.y[i] + z[i] * other.z[i];
  }
};

// The value that kFewestWitnesses - 1 others lie below. REQUIRES: there are so many; none is NaN.
float LeastButTwo(std::span<const float> values) {
  static_assert(kFewestWitnesses == 3);
  float first = kInfinity, second = kInfinity, third = kInfinity;
  for (const float value : values) {
    const float larger = std::max(first, value), largest = std::max(second, larger);
    first = std::min(first, value);
    second = std::min(second, larger);
    third = std::min(third, largest);
  }
  return third;
}

// The pieces of surface by which the neighbors of a point judge it.
class Pieces {
 public:
  // `offset`: from the piece's point to the one that is judged; `to_index`: what curvatures are multiplied with.
  void Add(const Vector& offset, const Vector& normal, const PointCurvature& piece, double to_index) {
    offsets_.Set(count_, offset);
    normals_.Set(count_, normal);
    d1_.Set(count_, piece.d1);
    d2_.Set(count_, piece.d2);
    half_k1_[count_] = static_cast<float>(0.5 * to_index * piece.k1);
    half_k2_[count_] = static_cast<float>(0.5 * to_index * piece.k2);
    ++count_;
  }
  size_t count() const { return count_; }

  // That of the point above the piece that it is third nearest to.
  float ThirdLeastHeight() const {
    std::array<float, kJudges> heights;
    for (size_t i = 0; i < count_; ++i) {
      const float along1 = offsets_.DotAt(i, d1_), along2 = offsets_.DotAt(i, d2_);
      const float bend = half_k1_[i] * (along1 * along1) + half_k2_[i] * (along2 * along2);
      heights[i] = std::min(kMostHeight, std::abs(offsets_.DotAt(i, normals_) + bend));
    }
    return LeastButTwo({heights.data(), count_});
  }

 private:
  size_t count_ = 0;
  JudgeVectors offsets_, normals_, d1_, d2_;
  std::array<float, kJudges> half_k1_, half_k2_;
};

// What nine in ten of the values, which it reorders, stay below; infinity if there are none.
double UsualOf(std::vector<double>& values) {
  return values.empty() ? std::numeric_limits<double>::infinity() : Quantile(values, kShareOfUsualValues);
}

// The middle one of `count` values, which it reorders.
float MedianOf(float* values, size_t count) {
  float* const middle = values + count / 2;
  std::nth_element(values, middle, values + count);
  return *middle;
}

}  // namespace

bool LooksForOutliers(const EstimatorOptions& options) { return MindsEdges(options); }

std::vector<GroupPhase> OutlierRun::Phases() {
  std::vector<GroupPhase> phases;
  for (size_t round = 0; round < kRounds; ++round) {
    const auto has_round = [this, round] { return HasRound(round); };
    phases.push_back(
        {kOutlierPhase, round == 0 ? std::function<absl::Status()>([this] { return Allocate(); }) : nullptr,
         [this](size_t group, WorkerScratch& scratch) { return Measure(group, static_cast<NearestScratch&>(scratch)); },
         has_round});
    phases.push_back({kOutlierPhase,
                      [this, round] {
                        if (round == 0) FindUsual();
                        return absl::OkStatus();
                      },
                      [this, round](size_t group, WorkerScratch&) {
                        Judge(group, round);
                        return absl::OkStatus();
                      },
                      has_round});
    phases.push_back({kOutlierPhase, nullptr,
                      [this, round](size_t group, WorkerScratch& scratch) {
                        return Compare(group, round, static_cast<NearestScratch&>(scratch));
                      },
                      has_round});
  }
  return phases;
}

absl::Status OutlierRun::Allocate() {
  const size_t count = index_.point_count();
  auto deviations = PageArray<float>::Create(count);
  if (!deviations.ok()) return deviations.status();
  auto spacings = PageArray<float>::Create(count);
  if (!spacings.ok()) return spacings.status();
  auto agreements = PageArray<float>::Create(count);
  if (!agreements.ok()) return agreements.status();
  auto marks = PageArray<Mark>::Create(count);
  if (!marks.ok()) return marks.status();
  deviations_ = *std::move(deviations);
  spacings_ = *std::move(spacings);
  agreements_ = *std::move(agreements);
  marks_ = *std::move(marks);
  std::fill_n(marks_.data(), count, Mark::kNone);
  return absl::OkStatus();
}

absl::Status OutlierRun::Measure(size_t group, NearestScratch& scratch) {
  const size_t first = group * SpatialIndex::kGroupPoints;
  std::bitset<SpatialIndex::kGroupPoints> is_left;
  for (size_t k = 0; k < SpatialIndex::kGroupPoints; ++k) {
    is_left[k] = first + k < index_.point_count() && marks_[first + k] != Mark::kOutlier;
  }
  size_t measured = 0, settled = 0;
  const auto measure = [&](size_t nearest) {
    return ForEachNearest(
        index_, group, nearest, scratch, [&](size_t place) { return is_left[place - first]; },
        [&](size_t i, std::span<const NearestPoint> neighbors) {
          const bool is_settled = MeasurePoint(i, neighbors, scratch);
          ++measured;
          settled += is_settled ? 1 : 0;
          if (is_settled) is_left.reset(static_cast<size_t>(scratch.points.place[i]) - first);
        });
  };
  const bool looks_at_few = scratch.may_look_at_few;
  if (looks_at_few) {
    if (absl::Status status = measure(kNearestFew); !status.ok()) return status;
    scratch.rest = 0;  // the second look takes on all that are left
    scratch.may_look_at_few = 2 * settled >= measured;
  }
  absl::Status status = measure(NearestScratch::kNearest);
  if (!looks_at_few) scratch.may_look_at_few = 2 * settled >= measured;
  return status;
}

bool OutlierRun::MeasurePoint(size_t i, std::span<const NearestPoint> neighbors, const NearestScratch& scratch) {
  const auto place = static_cast<size_t>(scratch.points.place[i]);
  neighbors = WithoutCopies(neighbors);
  if (neighbors.empty()) {
    spacings_[place] = 0.0f;
    deviations_[place] = agreements_[place] = kNaN;
    return false;
  }
  const size_t spacing_neighbor = std::min(kSpacingNeighbor, neighbors.size() - 1);
  spacings_[place] = std::sqrt(neighbors[spacing_neighbor].squared_distance) / kSpacingsToIt;
  agreements_[place] = judges_normals_ ? AgreementOf(i, neighbors, scratch) : kNaN;
  Vector position;
  scratch.points.query.Get(i, position.data());
  const double to_index = std::ldexp(1.0, -index_.scale_exponent());
  const float settled = kLeastMedian * spacings_[place];
  const bool agrees = !judges_normals_ || agreements_[place] >= kSettledCosine;
  Pieces pieces;
  for (const NearestPoint& neighbor : neighbors) {
    if (pieces.count() == kJudges) break;
    if (!IsJudge(neighbor.place)) continue;
    const size_t leaf = neighbor.place / SpatialIndex::kLeafSize;
    const Vector middle = VectorAt(index_.positions(leaf), neighbor.place);
    pieces.Add({position[0] - middle[0], position[1] - middle[1], position[2] - middle[2]},
               VectorAt(index_.normals(leaf), neighbor.place), PieceOf(neighbor.place), to_index);
    if (pieces.count() != kFewestJudges) continue;
    deviations_[place] = pieces.ThirdLeastHeight();
    if (deviations_[place] <= settled) return agrees;
  }
  deviations_[place] = pieces.count() >= kFewestJudges ? pieces.ThirdLeastHeight() : kNaN;
  return false;
}

// Where neighbors' normals are opposed, as a few outliers with any normals make them, the piece is the point's plane.
const PointCurvature& OutlierRun::PieceOf(size_t place) const {
  static constexpr PointCurvature kPlane{};
  const PointCurvature& found = result(place);
  return found.status == PointStatus::kOk ? found : kPlane;
}

// Neighbors at other places than the point itself, of which `neighbors` are the nearest first: a copy lies on whatever
// its point lies on.
std::span<const NearestPoint> OutlierRun::WithoutCopies(std::span<const NearestPoint> neighbors) {
  size_t copies = 0;
  while (copies < neighbors.size() && neighbors[copies].squared_distance == 0.0f) ++copies;
  return neighbors.subspan(copies);
}

// Normals that are NaN have no say.
float OutlierRun::AgreementOf(size_t i, std::span<const NearestPoint> neighbors, const NearestScratch& scratch) const {
  Vector own;
  scratch.points.normal.Get(i, own.data());
  std::array<float, kJudges> negative_cosines;
  size_t judges = 0;
  for (const NearestPoint& neighbor : neighbors) {
    if (judges == kJudges) break;
    if (marks_[neighbor.place] == Mark::kOutlier) continue;
    const Vector other = VectorAt(index_.normals(neighbor.place / SpatialIndex::kLeafSize), neighbor.place);
    const float cosine = own[0] * other[0] + own[1] * other[1] + own[2] * other[2];
    if (std::isnan(cosine)) continue;
    negative_cosines[judges++] = -cosine;
    if (judges != kFewestJudges) continue;
    const float agreement = -LeastButTwo({negative_cosines.data(), judges});
    if (agreement >= kSettledCosine) return agreement;
  }
  return judges >= kFewestJudges ? -LeastButTwo({negative_cosines.data(), judges}) : kNaN;
}

bool OutlierRun::IsJudge(size_t place) const {
  const PointStatus status = result(place).status;
  return marks_[place] != Mark::kOutlier && (status == PointStatus::kOk || status == PointStatus::kOpposedNormals);
}

void OutlierRun::FindUsual() {
  const size_t count = index_.point_count();
  const size_t step = std::max<size_t>(1, count / kMostSampled);
  std::vector<double> angles, deviations;
  for (size_t place = 0; place < count; place += step) {
    if (std::isfinite(agreements_[place])) angles.push_back(std::acos(std::clamp(agreements_[place], -1.0f, 1.0f)));
  }
  lonely_cosine_ = std::cos(std::clamp(kTimesUsualAngle * UsualOf(angles), kLonelyAngle, kMostLonelyAngle));
  for (size_t place = 0; place < count; place += step) {
    if (!MayBeUsual(place) || !(spacings_[place] > 0.0f)) continue;
    deviations.push_back(double{deviations_[place]} / spacings_[place]);
  }
  usual_deviation_ = UsualOf(deviations);
}

void OutlierRun::Judge(size_t group, size_t round) {
  const size_t first = group * SpatialIndex::kGroupPoints;
  const size_t last = std::min(first + SpatialIndex::kGroupPoints, index_.point_count());
  std::array<float, SpatialIndex::kGroupPoints> deviations, spacings;
  size_t deviation_count = 0, spacing_count = 0;
  for (size_t place = first; place < last; ++place) {
    if (marks_[place] == Mark::kOutlier) {
      deviations_[place] = agreements_[place] = kNaN;
      continue;
    }
    spacings[spacing_count++] = spacings_[place];
    if (MayBeUsual(place)) deviations[deviation_count++] = deviations_[place];
  }
  if (spacing_count == 0) return;
  const float spacing = MedianOf(spacings.data(), spacing_count);
  const float median = deviation_count == 0 ? kInfinity : MedianOf(deviations.data(), deviation_count);
  const double least = search_ == OutlierSearch::kFirst ? kLeastOfSpacing : kLeastOfSpacingAgain;
  const double most = std::max({double{kTimesMedian} * std::max(median, kLeastMedian * spacing), least * spacing,
                                kTimesUsual * usual_deviation_ * spacing});
  size_t found = 0;
  for (size_t place = first; place < last; ++place) {
    if (marks_[place] == Mark::kOutlier) continue;
    const bool is_suspect = spacing > 0.0f && deviations_[place] > most;
    const bool is_lonely = IsLonely(place);
    if (is_lonely || (is_suspect && deviations_[place] > kFarInSpacings * spacing)) {
      marks_[place] = Mark::kOutlier;
      ++found;
      if (is_lonely) deviations_[place] = kNaN;  // it tells nothing of how much others may deviate
    } else if (is_suspect) {
      marks_[place] = Mark::kSuspect;
    }
  }
  found_[round].fetch_add(found, std::memory_order_relaxed);
}

absl::Status OutlierRun::Compare(size_t group, size_t round, NearestScratch& scratch) {
  size_t found = 0;
  absl::Status status = ForEachNearest(
      index_, group, NearestScratch::kNearest, scratch,
      [this](size_t place) { return marks_[place] == Mark::kSuspect; },
      [&](size_t i, std::span<const NearestPoint> neighbors) {
        const auto place = static_cast<size_t>(scratch.points.place[i]);
        const bool is_outlier = DeviatesAlone(place, neighbors);
        marks_[place] = is_outlier ? Mark::kOutlier : Mark::kNone;
        found += is_outlier ? 1 : 0;
      });
  found_[round].fetch_add(found, std::memory_order_relaxed);
  return status;
}

bool OutlierRun::DeviatesAlone(size_t place, std::span<const NearestPoint> neighbors) const {
  std::array<float, NearestScratch::kNearest + 1> deviations;
  size_t count = 0;
  for (const NearestPoint& neighbor : neighbors) {
    if (std::isfinite(deviations_[neighbor.place])) deviations[count++] = deviations_[neighbor.place];
  }
  if (count < kFewestJudges) return true;
  float* const upper = deviations.data() + count - 1 - count / kNeighborsAbove;
  std::nth_element(deviations.data(), upper, deviations.data() + count);
  return deviations_[place] > kTimesNeighbors * *upper;
}

std::vector<int32_t> OutlierRun::TakeOutliers() {
  size_t count = 0;
  for (const std::atomic<size_t>& found : found_) count += found;
  std::vector<int32_t> outliers;
  if (count > index_.point_count() / kMostShareInverse) return outliers;
  outliers.reserve(count);
  for (size_t place = 0; place < index_.point_count() && count > 0; ++place) {
    if (marks_[place] == Mark::kOutlier) outliers.push_back(rank(place));
  }
  return outliers;
}

}  // namespace curvd
