// Finds from a sample of the points how many neighbors normals should be made of, and by which method.
//
// Each sampled point gets normals from jets of degree 2 and 4 at a ladder of neighbor counts. What noise does to a
// normal follows from the residuals of the fits and from where the neighbors lie: the covariance of the coefficients of
// least squares. What the surface's bends beyond the jet do to it shows in how the normal changes with
// K, in excess of what noise explains. The sum of both is least at the chosen scale. Bends have a larger weight where
// curvature is made of the normals: it averages their noise, but cannot undo what was smoothed away. Where one part of
// the sample is much noisier than the rest, each part gets the scale that is best for it (noisy_parts.cc).
// Where edges of the surface make the best scale small, points away from them get a larger one (edges/edge_parts.cc).
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "core/index/spatial_index.h"
#include "core/normals/fits/normal_plan.h"
#include "core/normals/fits/normal_scratch.h"
#include "core/normals/normal_fit.h"
#include "core/normals/sample_scratch.h"

namespace curvd {

struct ChosenScale {
  NormalFit fit;
  // Of the positions' noise, in the caller's unit; none where no point of the sample told. Where a part is noisier than
  // others, that of the others.
  std::optional<double> sigma;
  // Of the noisier part, if there is one, and the share of the points that lie in it.
  std::optional<double> noisy_sigma;
  double noisy_share = 0.0;
  // What its normals are expected to err by, squared, in radians: by noise, and by bends with their weight. Infinity
  // where the sample tells nothing.
  double squared_error = std::numeric_limits<double>::infinity();
};

// What normals are made for.
enum class NormalAim : uint8_t {
  kNormals,    // they are the result
  kCurvature,  // the result is made of those of whole neighborhoods
};

// The mean number of points at the place of one of a group, itself included, as far as they are of this group. Those
// nearly there count, too, if they are too many for chance.
double MeanCopies(const SpatialIndex& index, size_t group);

// Usage: block_count blocks of RunBlock, in any order and on any threads; then Choose. What is chosen depends on the
// index alone, not on threads. RunBlock is thread-safe for distinct blocks and workers.
class ScalePilot {
 public:
  // At most so many points are sampled.
  static constexpr size_t kMostGroups = 128;
  // No scale has more neighbors: what these could still smooth, whoever uses the normals can, at less cost.
  static constexpr uint32_t kMostNeighbors = 1086;
  // The cloud, or a part that gets a scale of its own, has at least so many times as many points.
  static constexpr size_t kLeastTimes = 3;
  // Errors below this are all good enough: squared radians.
  static constexpr double kNegligible = 1e-10;
  static constexpr size_t kPointsPerGroup = SpatialIndex::kGroupLeaves;

  // `method`: the one to find a scale for; none: the better of kJet2 and kJet4. No neighborhood is larger than
  // max_neighbor_count. REQUIRES: `index` has normals, of any values, and outlives the pilot.
  ScalePilot(const SpatialIndex& index, std::optional<NormalMethod> method, uint32_t max_neighbor_count,
             int thread_count, NormalAim aim);

  // 0 where the cloud is too small for a choice.
  size_t block_count() const { return candidates_.size() * groups_.size(); }
  // Errors: ErrorKind::kCancelled once *stopped is true. May throw std::bad_alloc.
  absl::Status RunBlock(size_t block, int worker, const std::atomic<bool>& stopped);
  // One scale; or two, where one part of the cloud is much noisier than the other (NoisyPart), or where there are edges
  // (EdgePart); squared_error is then that of the one scale without an edge part. REQUIRES: all blocks have run.
  ChosenScale Choose();
  // The squared error that noise makes of normals of such a fit, as the nearest scale of the sample shows it; none
  // where no point of the sample told. REQUIRES: as Choose; both methods are looked at.
  std::optional<double> NoiseOf(NormalMethod method, uint32_t neighbor_count);

  // Bytes that the pilot holds, but for its workers' scratch; and that the scratch of one worker holds at most.
  size_t bytes() const {
    return outcomes_.capacity() * sizeof(Outcome) + groups_.capacity() * sizeof(size_t) +
           copies_.capacity() * sizeof(double);
  }
  static size_t ScratchBytes(size_t point_count, uint32_t max_neighbor_count);
  // What block_count is at most for so many points.
  static size_t MostBlocks(size_t point_count, uint32_t max_neighbor_count);

 private:
  // Two parts of the sample, of which one is noisier.
  struct Parts {
    std::vector<bool> is_noisy;     // by group
    std::vector<double> variances;  // likewise, by the probe
    std::vector<double> noises;     // likewise: the variance of the noise; 0 where it may be that of bends
    uint32_t probe_count;           // as NoisyPart has it, and the next two
    double least_variance, quiet_variance;
    double noisy_share;  // of the groups
  };
  // Where an outcome belongs while one part is looked at: to this part; to it, with neighbors of the noisy part among
  // those of the quiet one; or to the other part.
  enum class Part : uint8_t { kOwn, kMixed, kOther };
  struct Candidate {
    NormalFit fit;
    NormalPlan plan;
    uint32_t count() const { return std::get<NeighborCount>(fit.neighborhood).count; }
    // Of a point, in any unit: a search, and the products of monomials over the neighbors.
    size_t cost() const {
      const size_t fit = count() * static_cast<size_t>(8 + JetSize(2 * plan.degree));
      return plan.shares ? fit / SpatialIndex::kLeafSize : fit;
    }
  };
  // Of one candidate at one sampled point. Lengths are in the index's unit.
  struct Outcome {
    std::array<float, 3> normal;
    float radius;
    float mean_square;  // of the distances of the neighbors from the fit
    float noise;        // the squared error of the normal that noise of unit standard deviation makes
    float excess;       // how many times the noise is that of as many neighbors that fill a disc
    bool is_fitted;
    Part part = Part::kOwn;
    bool ok() const { return is_fitted && part == Part::kOwn; }
  };

  // `copies` is the mean number of points at the place of one, itself included.
  static Outcome OutcomeOf(const Candidate& candidate, double copies, const NormalScratch& fits,
                           const FittedPoint& fitted);
  // Of the groups, the median over their points of the variance of the residuals of a candidate; 0 where it fits none.
  std::vector<double> GroupVariances(size_t candidate) const;
  double RadiusOf(size_t candidate, const Parts& parts, bool noisy) const;  // the median of a part's; 0 for none
  // How the fits of a candidate, of degree 2, part the sample; none where they do not, or where its bends do.
  std::optional<Parts> PartsBy(size_t candidate) const;
  bool KeepsNoise(const NormalFit& fit) const;  // of the quiet part, while it is looked at
  bool DifferInNoise(const Parts& parts);
  std::optional<Parts> FindParts();
  // Makes the noisy part, or the quiet one, that which is looked at.
  void LookAt(const Parts& parts, bool noisy);
  void LookAtAll();
  ChosenScale ChooseOne() const;
  // Whether a candidate's fit of a sampled point leaves more of the heights than noise of that standard deviation does.
  bool LeavesMore(size_t candidate, size_t sample, double sigma) const;
  double CrossingShare(size_t candidate,
                       double sigma) const;  // of the fits: those that leave more; 1 where there is none
  // How many times as large a variance of noise four times as many neighbors show, at points where a candidate's fit
  // leaves more than noise does, in the median; 1 where there is no such point.
  double CrossingGrowth(size_t candidate, double sigma) const;
  // Whether edges are why fits of a candidate leave more than noise does, and why not all of them do. `fewest` is the
  // least of the method that is much larger than noise. REQUIRES: it has a quarter of the neighbors or less.
  bool CrossesEdges(size_t candidate, size_t fewest, double sigma) const;
  // Makes those points of the sample the ones that are looked at whose fits leave no more than noise does.
  void LookAtFaces(double sigma);
  // The same scale; or, if edges are what made it small, a larger one with an edge part.
  ChosenScale MindEdges(const ChosenScale& chosen);
  std::optional<double> NoiseOfOne(NormalMethod method, uint32_t neighbor_count) const;

  Outcome& outcome(size_t candidate, size_t sample) { return outcomes_[candidate * sample_count() + sample]; }
  const Outcome& outcome(size_t candidate, size_t sample) const {
    return outcomes_[candidate * sample_count() + sample];
  }
  // Two rungs of the ladder double the count.
  static constexpr size_t kRungsPerDoubling = 2;
  // Copies of a point share its noise: of so many coefficients, each takes the freedom of several neighbors.
  double FreedomAt(size_t candidate, size_t sample) const;
  double MedianFreedom(size_t candidate) const;  // over the groups
  size_t sample_count() const { return groups_.size() * kPointsPerGroup; }
  void AddCandidates(NormalMethod method, size_t most);
  // Over the points that the candidate fits, and whose neighbors determine the fit if there are such: the median
  // radius, and the median variance of the noise as its residuals show it; none where no point is fitted.
  struct Medians {
    double radius;
    double variance;
  };
  std::optional<Medians> MediansOf(size_t candidate) const;
  // Whether the places of the neighbors determine the fit, and not the noise of that standard deviation.
  static bool IsDetermined(const Outcome& point, double sigma);
  // How many points have fits that their neighbors determine beyond doubt.
  size_t DeterminedCount(size_t candidate) const;
  // Whether all fits are, but for a few.
  bool IsMostlyDetermined(size_t candidate) const;
  double UndeterminedShare(size_t candidate, double sigma) const;  // of the fits; 1 where there is none
  // Whether too many fits are undetermined, but not at a larger scale of the method: where there are lines. And whether
  // that is so at any scale.
  bool CrossesTooFew(size_t candidate, double sigma) const;
  bool SeesLines(double sigma) const;
  std::optional<double> Sigma() const;
  // The variance of the noise around a point of the sample: that of its group, while parts are looked at, if it is
  // known.
  double NoiseAt(size_t sample, double sigma) const;
  // The squared error of a candidate's normals that noise makes.
  double Noise(size_t candidate, double sigma) const;
  // The squared error of the normals at `large` that bends make, as far as their change since `small` shows it beyond
  // what noise explains.
  double Bends(size_t small, size_t large, double sigma) const;
  double ErrorOf(size_t candidate, double sigma, const std::vector<bool>& usable) const;
  // Whether `a` is to be taken where both are good enough.
  static bool IsRather(const Candidate& a, const Candidate& b);
  // Whether the part that is looked at has enough points for such neighborhoods.
  bool IsSmallEnough(const Candidate& candidate) const;
  // The largest that are, or the smallest. REQUIRES: there is a candidate of the method.
  const Candidate& LargestOf(NormalMethod method) const;
  // The least radius of neighborhoods that are much larger than noise of that standard deviation, and than the lattice
  // on which positions may lie.
  double LeastRadius(double sigma) const;
  // Whether the neighborhoods are so much larger than the noise that a fit finds the surface in it.
  bool IsLargeEnough(size_t candidate, double sigma) const;
  // The share of the normals that turn to elsewhere when the neighborhoods double. None where no candidate has twice
  // the count.
  std::optional<double> UnsettledShare(size_t candidate) const;
  // The largest such share with which a scale is usable.
  double MostUnsettled() const;
  size_t FittedCount(size_t candidate) const;  // of those of the part that is looked at
  bool IsMostlyMixed(size_t candidate) const;
  // Which candidates a choice can be made of.
  std::vector<bool> Usable(double sigma) const;

  const SpatialIndex& index_;
  const NormalAim aim_;
  const double lattice_step_;
  std::vector<size_t> groups_;
  std::vector<double> copies_;  // by group: the mean number of points at the place of one
  std::vector<Candidate> candidates_;
  std::vector<Outcome> outcomes_;
  std::vector<double> group_noises_;  // while parts are looked at: Parts::noises
  double share_ = 1.0;                // of the points, of the part that is looked at
  SampleScratch<NormalScratch> scratch_;
  ChosenScale fallback_;
};

}  // namespace curvd
