#include "core/normals/trust/fit_probe.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>

#include "core/base/median.h"
#include "core/estimators/fits/jet_systems.h"
#include "core/normals/half_normals.h"

namespace curvd {
namespace {

constexpr float kNanValue = std::numeric_limits<float>::quiet_NaN();

constexpr size_t kMostProbedGroups = 64;
// A neighborhood of more than this share of the cloud is no neighborhood.
constexpr size_t kLargestProbedShare = 8;
// Two rungs double the number of neighbors, of planes, jets of degree 2, and of degree 4.
constexpr uint32_t kProbedCounts[] = {12, 17, 24, 34, 48, 68, 96, 136, 192};
constexpr uint32_t kFewestOfJets[] = {17, 24};
// Planes of fewer neighbors lie on one of two sheets where all jets mix these, and take them for noise.
constexpr uint32_t kFewestProbed = 10;
// Those that tell noise.
constexpr uint32_t kNoiseCounts[] = {17, 24};
// A smoother surface is a jet of degree 4 of so many neighbors, which has little noise and little bend.
constexpr uint32_t kSmoothCount = 96;
// What noise may do to a plane of 12 neighbors without being looked at: squared radians.
constexpr uint32_t kFewNeighbors = 12;
constexpr double kNegligibleNoise = 1e-6;
// Around the nearest rung those between are tried, which are 4 % apart.
constexpr int kFineSteps = 4, kFineStepsPerDoubling = 16;
// Normals are those of fits where their difference is less than this, and more so where it is a median of few samples.
// Measured: 0 to 0.3 where they are, 0.6 and more where they are not.
constexpr double kMostDifference = 0.45;
// Fits of few and of many neighbors must differ by hardly more than noise: else the points are too few for the surface,
// or lie on lines, or on two sheets, and nothing tells what noise does to fits. Measured: 1.5 to 1.9 where they do, 4
// and more where they do not.
constexpr double kMostBetweenFits = 3.0;
// Noise may differ from place to place: there it is the least that jets of degree 4 of so many neighbors leave, and
// this many times that of the whole cloud at most, since they leave detail as well.
constexpr uint32_t kLocalNoiseCounts[] = {48, 96};
constexpr double kMostOverNoise = 2.0;
// Of samples, for a median.
constexpr size_t kFewestSamples = 32;
// What jets of degree 2 of few neighbors leave is noise where others leave nearly as much: else jets fit the surface's
// detail, and not all of what they leave of it turns their normals.
constexpr double kLeastOfNoise = 0.5;
// Over an even disc, slopes of degree 4 have the noise of those of a degree less than 3 of so many times fewer
// neighbors.
constexpr uint32_t kNoiseOfQuartics = 3;

class FitProbePhase final : public Phase {
 public:
  FitProbePhase(FitProbe& probe, std::string_view name) : probe_(probe), name_(name) {}
  std::string_view name() const override { return name_; }
  absl::StatusOr<size_t> Begin() override { return probe_.block_count(); }
  absl::Status RunBlock(const BlockContext& context) override {
    return probe_.RunBlock(context.block, context.worker, context.stopped);
  }

 private:
  FitProbe& probe_;
  const std::string_view name_;
};

std::array<double, 3> Minus(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

double Dot(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

double Square(const std::array<double, 3>& a) { return Dot(a, a); }

}  // namespace

FitProbe::FitProbe(const SpatialIndex& index, uint32_t max_neighbor_count, int thread_count)
    : index_(index),
      groups_(SampleGroups(index, kMostProbedGroups)),
      most_neighbors_(std::min<size_t>(index.point_count() / kLargestProbedShare, max_neighbor_count)),
      given_(sample_count(), {kNanValue, kNanValue, kNanValue}),
      scratch_(static_cast<size_t>(thread_count)) {}

bool FitProbe::AddFits() {
  first_new_ = fits_.size();
  switch (stage_) {
    case Stage::kNone:
      stage_ = Stage::kNoise;
      for (const uint32_t count : kNoiseCounts) Add(NormalMethod::kJet2, count);
      Add(NormalMethod::kPca, kFewNeighbors);
      if (fits_.size() > std::size(kNoiseCounts)) break;
      stage_ = Stage::kDone;
      return false;
    case Stage::kNoise:
      stage_ = Stage::kCoarse;
      noise_ = NoiseOfPositions();
      if (NoiseOfFew() < kNegligibleNoise) {
        stage_ = Stage::kDone;
        return false;
      }
      for (const uint32_t count : kProbedCounts) {
        Add(NormalMethod::kPca, count);
        if (count >= kFewestOfJets[0]) Add(NormalMethod::kJet2, count);
        if (count >= kFewestOfJets[1]) Add(NormalMethod::kJet4, count);
      }
      break;
    case Stage::kCoarse: {
      stage_ = Stage::kFine;
      noise_ = NoiseOfPositions();
      const Fit nearest = fits_[FindNearest().fit];
      for (int step = -kFineSteps; step <= kFineSteps; ++step) {
        Add(nearest.method, nearest.count * std::exp2(static_cast<double>(step) / kFineStepsPerDoubling));
      }
      break;
    }
    case Stage::kFine:
      stage_ = Stage::kDone;
      Find();
      return false;
    case Stage::kDone:
      return false;
  }
  fitted_.resize(fits_.size() * sample_count(), {{kNanValue, kNanValue, kNanValue}, kNanValue, kNanValue});
  return true;
}

void FitProbe::Add(NormalMethod method, double count) {
  const auto neighbors = static_cast<uint32_t>(std::lround(count));
  if (neighbors > most_neighbors_ || neighbors < kFewestProbed) return;
  for (const Fit& fit : fits_) {
    if (fit.method == method && fit.count == neighbors) return;
  }
  NormalFit fit;
  fit.method = method;
  fit.neighborhood = NeighborCount{neighbors};
  fits_.push_back({method, neighbors, NormalPlan(fit, index_)});
}

size_t FitProbe::NearestFit(NormalMethod method, uint32_t count) const {
  size_t nearest = fits_.size();
  double least = std::numeric_limits<double>::infinity();
  for (size_t f = 0; f < fits_.size(); ++f) {
    const double distance = std::abs(std::log2(static_cast<double>(fits_[f].count) / count));
    if (fits_[f].method != method || distance >= least) continue;
    nearest = f;
    least = distance;
  }
  return nearest;
}

absl::Status FitProbe::RunBlock(size_t block, int worker, const std::atomic<bool>& stopped) {
  std::unique_ptr<NormalScratch>& scratch = scratch_[static_cast<size_t>(worker)];
  if (scratch == nullptr) {
    scratch = std::make_unique<NormalScratch>();
    scratch->most_work = std::numeric_limits<uint64_t>::max();  // four points are few
  }
  NormalScratch& s = *scratch;
  s.stopped = &stopped;
  const size_t f = first_new_ + block / groups_.size(), first_sample = block % groups_.size() * kPointsPerGroup;
  const size_t group = groups_[block % groups_.size()];
  const absl::Status status = FitGroup(index_, fits_[f].plan, group, GroupSample::kOneOfEachLeaf, s);
  if (!status.ok()) return status;
  for (size_t i = 0; i < s.points.size; ++i) {
    if (s.points.status[i] != PointStatus::kOk) continue;
    const auto place = static_cast<size_t>(s.points.place[i]);
    const size_t leaf = place / SpatialIndex::kLeafSize, lane = place % SpatialIndex::kLeafSize;
    const size_t sample = first_sample + leaf - group * SpatialIndex::kGroupLeaves;
    const float radius = s.frames.rho[i];
    fitted_[f * sample_count() + sample] = {
        {static_cast<float>(s.normal.x[i]), static_cast<float>(s.normal.y[i]), static_cast<float>(s.normal.z[i])},
        radius,
        static_cast<float>(s.mean_square[i]) * radius * radius};
    const SpatialIndex::LeafNormals& normals = index_.normals(leaf);
    // Of the first fit alone, so that no two blocks write it.
    if (f == 0) given_[sample] = {normals.x[lane], normals.y[lane], normals.z[lane]};
  }
  return absl::OkStatus();
}

FitProbe::Vector FitProbe::NormalOf(size_t fit, size_t sample) const {
  const Normal &normal = fitted(fit, sample).normal, &given = given_[sample];
  const float along = normal[0] * given[0] + normal[1] * given[1] + normal[2] * given[2];
  const double sign = along < 0.0f ? -1.0 : 1.0;
  return {sign * normal[0], sign * normal[1], sign * normal[2]};
}

double FitProbe::VarianceLeftBy(size_t jet, size_t sample) const {
  const double count = fits_[jet].count, freedom = count - JetSize(std::max(fits_[jet].plan.degree, 1));
  return fitted(jet, sample).mean_square * count / freedom;
}

double FitProbe::LeftBy(size_t jet) const {
  std::vector<double> variances;
  for (size_t i = 0; i < sample_count(); ++i) {
    const double variance = VarianceLeftBy(jet, i);
    if (!std::isnan(variance)) variances.push_back(variance);
  }
  return variances.empty() ? std::numeric_limits<double>::infinity() : Median(variances);
}

double FitProbe::NoiseOfPositions() const {
  double least = std::numeric_limits<double>::infinity();
  for (size_t f = 0; f < fits_.size(); ++f) {
    least = std::min(least, LeftBy(f));
  }
  return least;
}

bool FitProbe::IsCandidate(size_t fit) const {
  if (fits_[fit].method == NormalMethod::kPca) return true;
  const size_t jet = NearestFit(NormalMethod::kJet2, kNoiseCounts[0]);
  return noise_ >= kLeastOfNoise * LeftBy(jet);
}

double FitProbe::NoiseAt(size_t sample) const {
  double noise = kMostOverNoise * noise_;
  for (const uint32_t count : kLocalNoiseCounts) {
    const size_t jet = NearestFit(NormalMethod::kJet4, count);
    if (jet < fits_.size()) noise = std::min(noise, VarianceLeftBy(jet, sample));
  }
  return noise;
}

double FitProbe::NoiseOfFew() const {
  const size_t few = NearestFit(NormalMethod::kPca, kFewNeighbors);
  std::vector<double> noises;
  for (size_t i = 0; i < sample_count(); ++i) {
    const double noise = NoiseOf(few, i);
    if (!std::isnan(noise)) noises.push_back(noise);
  }
  return noises.empty() ? 0.0 : Median(noises);
}

double FitProbe::NoiseOf(size_t fit, size_t sample) const {
  // Of the two slopes of least squares, over an even disc.
  const double times = fits_[fit].method == NormalMethod::kJet4 ? 8.0 * kNoiseOfQuartics * kNoiseOfQuartics : 8.0;
  const double radius = fitted(fit, sample).radius;
  return times * NoiseAt(sample) / (fits_[fit].count * radius * radius);
}

double FitProbe::DifferenceOf(size_t fit, std::optional<size_t> other) const {
  std::vector<double> ratios;
  for (size_t i = 0; i < sample_count(); ++i) {
    const Vector from = other.has_value() ? NormalOf(*other, i) : GivenOf(i);
    const double ratio = Square(Minus(NormalOf(fit, i), from)) / NoiseOf(fit, i);
    if (!std::isnan(ratio)) ratios.push_back(ratio);
  }
  // As sums of two squared Gaussians the squares are distributed exponentially.
  return ratios.size() < kFewestSamples ? std::numeric_limits<double>::infinity() : Median(ratios) / std::numbers::ln2;
}

bool FitProbe::AreSettled() const {
  const size_t few = NearestFit(NormalMethod::kJet2, kNoiseCounts[0]),
               many = NearestFit(NormalMethod::kJet4, kSmoothCount);
  if (many == fits_.size() || fits_[many].count != kSmoothCount) return false;
  return DifferenceOf(few, many) <= kMostBetweenFits;
}

FitProbe::Nearest FitProbe::FindNearest() const {
  Nearest nearest{0, std::numeric_limits<double>::infinity()};
  for (size_t f = 0; f < fits_.size(); ++f) {
    if (!IsCandidate(f)) continue;
    const double difference = DifferenceOf(f, std::nullopt);
    if (difference < nearest.difference) nearest = {f, difference};
  }
  return nearest;
}

void FitProbe::Find() {
  const double most = kMostDifference * (1.0 - 2.0 / std::sqrt(static_cast<double>(sample_count())));
  const Nearest nearest = FindNearest();
  if (nearest.difference > most || !AreSettled()) return;
  const Fit& fit = fits_[nearest.fit];
  found_.emplace();
  found_->method = fit.method;
  found_->neighborhood = NeighborCount{fit.count};
  // Of few neighbors, halves determine planes at most, of as many as have that noise.
  if (fit.count >= LeastNeighborCountOfHalves(fit.method)) return;
  const uint32_t count = fit.method == NormalMethod::kJet4 ? fit.count / kNoiseOfQuartics : fit.count;
  found_->method = NormalMethod::kPca;
  found_->neighborhood = NeighborCount{std::max(count, LeastNeighborCountOfHalves(NormalMethod::kPca))};
}

size_t FitProbe::ScratchBytes(size_t point_count, uint32_t max_neighbor_count) {
  NormalFit largest;
  largest.method = NormalMethod::kJet4;
  constexpr uint32_t kMost = 2 * kProbedCounts[std::size(kProbedCounts) - 1];
  largest.neighborhood = NeighborCount{std::min(kMost, max_neighbor_count)};
  return NormalScratch::MostBytes(largest, point_count);
}

std::unique_ptr<Phase> MakeFitProbePhase(FitProbe& probe, std::string_view name) {
  return std::make_unique<FitProbePhase>(probe, name);
}

}  // namespace curvd
