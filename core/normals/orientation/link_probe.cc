#include "core/normals/orientation/link_probe.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/normals/fits/fit_group.h"
#include "core/normals/orientation/normal_links.h"
#include "core/normals/sample_groups.h"

namespace curvd {
namespace {

constexpr size_t kMostLinkGroups = 128;
// Neighbors whose positions vary less than this in their middle direction, compared with the widest, lie on a line.
// Those of points of a surface vary by 0.5 and more as much, at its border by 0.28, if there are many; of 13 points at
// random hardly any have less than 0.15. Those of a scan line vary by its noise.
constexpr double kLeastBreadth = 0.1;
// Points without a neighbor within so wide an angle have them on one side alone: those of a line that reach only the
// next one, and those of a border. Of 12 neighbors at random, one in a hundred points has such an angle.
constexpr double kWidestGap = 165.0 / 180.0 * std::numbers::pi;
// So few points on lines, and with neighbors on one side, do not matter; nor do those that are there with any count,
// such as the points of wires and borders.
constexpr double kMostOnLines = 0.05, kMostOneSided = 0.1, kAboveLeast = 1.5;

// The widest angle between two neighbors of point i, seen from it in the plane that lies best, in which there is no
// other one.
double WidestGap(const NormalScratch& s, size_t i) {
  const NeighborArrays& n = s.neighbors;
  const JetSystems& frame = s.system;
  std::vector<double> angles;
  for (size_t j = 0; j < n.count; ++j) {
    const double x = n.dx[j], y = n.dy[j], z = n.dz[j];
    const double u = x * frame.u.x[i] + y * frame.u.y[i] + z * frame.u.z[i];
    const double v = x * frame.v.x[i] + y * frame.v.y[i] + z * frame.v.z[i];
    if (u != 0.0 || v != 0.0) angles.push_back(std::atan2(v, u));
  }
  if (angles.empty()) return 2.0 * std::numbers::pi;
  std::sort(angles.begin(), angles.end());
  double widest = angles.front() + 2.0 * std::numbers::pi - angles.back();
  for (size_t j = 1; j < angles.size(); ++j) widest = std::max(widest, angles[j] - angles[j - 1]);
  return widest;
}

}  // namespace

LinkProbe::LinkProbe(const SpatialIndex& index, int thread_count)
    : index_(index), groups_(SampleGroups(index, kMostLinkGroups)), scratch_(thread_count) {
  static_assert(kLadder.front() == kLinksPerPoint && 2 * kLadder.back() == kMostLinksPerPoint);
  for (const size_t links : kLadder) {
    if (links < index.point_count()) plans_.emplace_back(PlaneFit(links + 1), index);
  }
}

bool LinkProbe::AddBlocks() {
  first_rung_ = looked_at_;
  // Most clouds need no more than one look.
  looked_at_ = looked_at_ == 0 ? std::min<size_t>(plans_.size(), 1) : plans_.size();
  const bool is_enough = first_rung_ == 1 && Spreads(0, kMostOnLines, kMostOneSided);
  return !is_enough && looked_at_ > first_rung_;
}

absl::Status LinkProbe::RunBlock(size_t block, int worker, const std::atomic<bool>& stopped) {
  NormalScratch& scratch = scratch_.Of(worker, stopped);
  const size_t rung = first_rung_ + block / groups_.size(), group = block % groups_.size();
  Tally& tally = tallies_[rung];
  scratch.inspect = [&scratch, &tally](size_t i) { tally.one_sided += WidestGap(scratch, i) > kWidestGap ? 1 : 0; };
  const absl::Status status = FitGroup(index_, plans_[rung], groups_[group], GroupSample::kOneOfEachLeaf, scratch);
  if (!status.ok()) return status;
  for (size_t i = 0; i < scratch.points.size; ++i) {
    const PointStatus point = scratch.points.status[i];
    const bool is_straight = point == PointStatus::kSingularFit;
    if (point != PointStatus::kOk && !is_straight) continue;
    tally.points += 1;
    tally.one_sided += is_straight ? 1 : 0;
    tally.on_lines += is_straight || scratch.breadth[i] < kLeastBreadth ? 1 : 0;
  }
  return absl::OkStatus();
}

bool LinkProbe::Spreads(size_t rung, double most_on_lines, double most_one_sided) const {
  return ShareOf(rung, &Tally::on_lines) <= most_on_lines && ShareOf(rung, &Tally::one_sided) <= most_one_sided;
}

double LinkProbe::ShareOf(size_t rung, std::atomic<uint32_t> Tally::*some) const {
  const uint32_t points = tallies_[rung].points;
  return points > 0 ? static_cast<double>(tallies_[rung].*some) / points : 1.0;
}

size_t LinkProbe::LinksPerPoint() const {
  if (plans_.empty() || Spreads(0, kMostOnLines, kMostOneSided)) return kLadder.front();
  double on_lines = 1.0, one_sided = 1.0;
  for (size_t rung = 0; rung < plans_.size(); ++rung) {
    on_lines = std::min(on_lines, ShareOf(rung, &Tally::on_lines));
    one_sided = std::min(one_sided, ShareOf(rung, &Tally::one_sided));
  }
  on_lines = std::max(kMostOnLines, kAboveLeast * on_lines);
  one_sided = std::max(kMostOneSided, kAboveLeast * one_sided);
  for (size_t rung = 0; rung < plans_.size(); ++rung) {
    // Twice as many reach lines on both sides, where those on one are nearer.
    if (Spreads(rung, on_lines, one_sided)) return rung == 0 ? kLadder[rung] : 2 * kLadder[rung];
  }
  return kLadder.front();
}

size_t LinkProbe::ScratchBytes(size_t point_count) {
  return NormalScratch::MostBytes(PlaneFit(std::min(kLadder.back() + 1, point_count)), point_count);
}

}  // namespace curvd
