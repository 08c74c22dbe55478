#include "core/normals/trust/jet_probe.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "core/base/median.h"
#include "core/estimators/fits/jet_systems.h"
#include "core/normals/fits/fit_group.h"
#include "core/normals/runs/half_normals.h"
#include "core/normals/sample_groups.h"

namespace curvd {
namespace {

constexpr float kNoNormal = std::numeric_limits<float>::quiet_NaN();
constexpr double kNoJet = std::numeric_limits<double>::infinity();

constexpr NormalMethod kProbedJets[] = {NormalMethod::kJet2, NormalMethod::kJet4};
constexpr uint32_t kFewestOfJets = 12, kMostOfJets = 1536;
// A neighborhood of more than this share of the cloud is no neighborhood.
constexpr size_t kLargestPartOfJets = 8;
// The jet whose residuals tell noise.
constexpr uint32_t kNoiseCount = 24;
// What noise may do to a plane of half as many neighbors without being looked at: squared radians.
constexpr double kNegligibleTurn = 1e-6;
// The given normals are looked at more closely where they are not farther from a rung than this part of the distance to
// a rung beside it. Measured: 0.8 at most where they were made by jets. Other normals may come as near: this saves
// work, and what it lets pass is told by what follows.
constexpr double kMostFromRung = 1.2;
// Each narrowing makes steps smaller by this factor, and tries so many of them to both sides.
constexpr double kNarrowing = 4.0;
constexpr int kStepsToSide = 5, kMostNarrowings = 8;
static_assert(size_t{4} * kStepsToSide + 2 <= JetProbe::kMostAtOnce);
constexpr size_t kFewestForMedian = 16;
// Over an even disc, slopes of degree 4 have the noise of those of a degree less than 3 of so many times fewer
// neighbors.
constexpr uint32_t kNoiseOfQuartics = 3;

uint32_t MostOfJets(size_t point_count, uint32_t max_neighbor_count) {
  const size_t most = std::min<size_t>(point_count / kLargestPartOfJets, max_neighbor_count);
  return static_cast<uint32_t>(std::min<size_t>(most, kMostOfJets));
}

NormalFit FitOf(NormalMethod method, uint32_t count) {
  NormalFit fit;
  fit.method = method;
  fit.neighborhood = NeighborCount{count};
  return fit;
}

// Of two unit normals, whatever their signs.
double SquaredDifference(const std::array<float, 3>& a, const std::array<float, 3>& b) {
  double sum = 0.0, difference = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double plus = static_cast<double>(a[axis]) + b[axis], minus = static_cast<double>(a[axis]) - b[axis];
    sum += plus * plus;
    difference += minus * minus;
  }
  return std::min(sum, difference);
}

double MedianOrNoJet(std::vector<double>& values) { return values.size() < kFewestForMedian ? kNoJet : Median(values); }

}  // namespace

JetProbe::JetProbe(const SpatialIndex& index, uint32_t max_neighbor_count, int thread_count)
    : index_(index),
      groups_(SampleGroups(index, kMostJetGroups)),
      most_neighbors_(MostOfJets(index.point_count(), max_neighbor_count)),
      given_(sample_count(), {kNoNormal, kNoNormal, kNoNormal}),
      noise_(sample_count(), kNoNormal),
      scratch_(thread_count) {}

bool JetProbe::AddBlocks() {
  first_new_ = jets_.size();
  switch (stage_) {
    case Stage::kNone:
      stage_ = Stage::kNoise;
      Add(NormalMethod::kJet2, kNoiseCount);
      break;
    case Stage::kNoise:
      stage_ = Stage::kRungs;
      if (IsNoiseNegligible()) break;
      for (const NormalMethod method : kProbedJets) {
        for (uint32_t count = kFewestOfJets; count <= kMostOfJets; count *= 2) Add(method, count);
      }
      break;
    case Stage::kRungs:
      stage_ = Stage::kSteps;
      GoOnWithNextMethod();
      break;
    case Stage::kSteps:
      if (narrowings_ < kMostNarrowings) AddStepsAround(NearestStep());
      if (jets_.size() > first_new_) break;
      if (const uint32_t count = Votes().Most().first; count > 0) {
        Add(method_, count / 2);
        Add(method_, 2 * count);
      }
      stage_ = Stage::kBends;
      if (jets_.size() > first_new_) break;
      [[fallthrough]];
    case Stage::kBends:
      stage_ = Stage::kSteps;
      Find();
      if (!found_.has_value()) GoOnWithNextMethod();
      break;
    case Stage::kDone:
      break;
  }
  if (jets_.size() == first_new_) {
    stage_ = Stage::kDone;
    return false;
  }
  fitted_.resize(jets_.size() * sample_count(), {kNoNormal, kNoNormal, kNoNormal});
  return true;
}

void JetProbe::Add(NormalMethod method, uint32_t count) {
  const auto coefficients = static_cast<uint32_t>(JetSize(JetDegree(method)));
  if (count > most_neighbors_ || count <= coefficients) return;
  if (FindJet(method, count) < jets_.size()) return;
  jets_.push_back({method, count, NormalPlan(FitOf(method, count), index_)});
}

void JetProbe::GoOnWithNextMethod() {
  while (methods_begun_ < std::size(kProbedJets) && jets_.size() == first_new_) {
    method_ = kProbedJets[methods_begun_++];
    step_ = 1.0;
    narrowings_ = 0;
    const std::optional<size_t> rung = NearestRung();
    if (rung.has_value()) AddStepsAround(*rung);
  }
}

void JetProbe::AddStepsAround(size_t jet) {
  const uint32_t around = jets_[jet].count;
  step_ /= kNarrowing;
  ++narrowings_;
  for (int i = -kStepsToSide; i <= kStepsToSide; ++i) {
    Add(method_, static_cast<uint32_t>(std::lround(around * std::exp2(i * step_))));
    // Steps of less than a neighbor leave none out.
    Add(method_, static_cast<uint32_t>(static_cast<int>(around) + i));
  }
}

size_t JetProbe::FindJet(NormalMethod method, uint32_t count) const {
  const auto jet =
      std::find_if(jets_.begin(), jets_.end(), [&](const Jet& j) { return j.method == method && j.count == count; });
  return static_cast<size_t>(jet - jets_.begin());
}

absl::Status JetProbe::RunBlock(size_t block, int worker, const std::atomic<bool>& stopped) {
  NormalScratch& s = scratch_.Of(worker, stopped);
  const size_t jet = first_new_ + block / groups_.size(), first_sample = block % groups_.size() * kPointsPerGroup;
  const size_t group = groups_[block % groups_.size()];
  const absl::Status status = FitGroup(index_, jets_[jet].plan, group, GroupSample::kOneOfEachLeaf, s);
  if (!status.ok()) return status;
  for (size_t i = 0; i < s.points.size; ++i) {
    if (s.points.status[i] != PointStatus::kOk) continue;
    const auto place = static_cast<size_t>(s.points.place[i]);
    const size_t leaf = place / SpatialIndex::kLeafSize, lane = place % SpatialIndex::kLeafSize;
    const size_t sample = first_sample + leaf - group * SpatialIndex::kGroupLeaves;
    fitted_[jet * sample_count() + sample] = {static_cast<float>(s.normal.x[i]), static_cast<float>(s.normal.y[i]),
                                              static_cast<float>(s.normal.z[i])};
    if (jet > 0) continue;  // so that no two blocks write the same
    const SpatialIndex::LeafNormals& normals = index_.normals(leaf);
    given_[sample] = {normals.x[lane], normals.y[lane], normals.z[lane]};
    noise_[sample] = static_cast<float>(s.mean_square[i]);
  }
  return absl::OkStatus();
}

double JetProbe::DifferenceFromGiven(size_t jet) const {
  std::vector<double> differences;
  for (size_t i = 0; i < sample_count(); ++i) {
    const double difference = SquaredDifference(normal(jet, i), given_[i]);
    if (!std::isnan(difference)) differences.push_back(difference);
  }
  return MedianOrNoJet(differences);
}

double JetProbe::DifferenceOf(size_t jet, size_t other) const {
  std::vector<double> differences;
  for (size_t i = 0; i < sample_count(); ++i) {
    const double difference = SquaredDifference(normal(jet, i), normal(other, i));
    if (!std::isnan(difference)) differences.push_back(difference);
  }
  return MedianOrNoJet(differences);
}

bool JetProbe::IsNoiseNegligible() const {
  std::vector<double> squares;
  for (const float square : noise_) {
    if (!std::isnan(square)) squares.push_back(square);
  }
  if (squares.size() < kFewestForMedian) return true;
  // A slope of least squares of k points over an even disc of radius r has the variance 4 / (k r^2) times that of the
  // noise; squared radii of neighborhoods grow with k.
  constexpr double kFreedom = static_cast<double>(kNoiseCount) / (kNoiseCount - JetSize(2));
  constexpr double kPlaneCount = kNoiseCount / 2.0, kPlaneRadius = 0.5;
  return 8.0 * kFreedom * Median(squares) / (kPlaneCount * kPlaneRadius) < kNegligibleTurn;
}

std::optional<size_t> JetProbe::NearestRung() const {
  std::optional<size_t> nearest;
  double least = kMostFromRung;
  for (size_t j = 0; j < jets_.size(); ++j) {
    if (jets_[j].method != method_) continue;
    // Noise makes the smaller difference from twice the neighbors, bends that from half of them: to that a jet with the
    // given normals is nearer in both cases.
    const size_t twice = FindJet(method_, jets_[j].count * 2), half = FindJet(method_, jets_[j].count / 2);
    double others = kNoJet;
    if (twice < jets_.size()) others = DifferenceOf(j, twice);
    if (half < jets_.size()) others = std::min(others, DifferenceOf(j, half));
    const double part = DifferenceFromGiven(j) / others;
    if (!(part < least)) continue;
    least = part;
    nearest = j;
  }
  return nearest;
}

size_t JetProbe::NearestStep() const {
  size_t nearest = first_new_ - 1;
  double least = kNoJet;
  for (size_t j = 0; j < first_new_; ++j) {
    if (jets_[j].method != method_) continue;
    const double difference = DifferenceFromGiven(j);
    if (!(difference < least)) continue;
    least = difference;
    nearest = j;
  }
  return nearest;
}

FitVotes JetProbe::Votes() const {
  FitVotes votes;
  for (size_t i = 0; i < sample_count(); ++i) {
    FitMatch match;
    for (size_t j = 0; j < jets_.size(); ++j) {
      if (jets_[j].method == method_) match.Take(jets_[j].count, SquaredDifference(normal(j, i), given_[i]));
    }
    const auto difference_of = [&](uint32_t count) {
      const size_t jet = FindJet(method_, count);
      return jet < jets_.size() ? SquaredDifference(normal(jet, i), given_[i]) : kNoJet;
    };
    const uint32_t count = match.count();
    votes.Add(match.is_known(), count, {match.least_of_others(), difference_of(count / 2), difference_of(2 * count)});
  }
  return votes;
}

void JetProbe::Find() {
  const FitVotes votes = Votes();
  auto [count, agreement] = votes.Most();
  if (!agreement.IsEnough(votes.known())) return;
  found_ = FoundFit{{method_, count}, std::nullopt};
  if (!agreement.IsMadeByNoise()) return;
  found_->of_halves = FitOf(method_, count);
  if (count >= LeastNeighborCountOfHalves(method_)) return;
  // Of few neighbors, halves determine planes at most, of as many as have that noise.
  if (method_ == NormalMethod::kJet4) count /= kNoiseOfQuartics;
  found_->of_halves = FitOf(NormalMethod::kPca, std::max(count, LeastNeighborCountOfHalves(NormalMethod::kPca)));
}

size_t JetProbe::ScratchBytes(size_t point_count, uint32_t max_neighbor_count) {
  const uint32_t most = MostOfJets(point_count, max_neighbor_count);
  return most < kNoiseCount ? 0 : NormalScratch::MostBytes(FitOf(NormalMethod::kJet4, most), point_count);
}

}  // namespace curvd
