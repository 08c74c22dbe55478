#include "client/surfaces/relaxation.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numbers>

namespace curv {
namespace {

constexpr int kRounds = 16;
constexpr double kReach = 1.6;    // distance where pushing ends, in spacings: first ring of neighbors only
constexpr double kStep = 0.45;    // of a round's push
constexpr double kMaxMove = 0.4;  // a round, in spacings

// A grid whose points are sorted by cell, x fastest: the cells around a cell are nine runs of points. A sweep in order
// moves the nine runs forward only, so that no table of cells is needed.
class SweptGrid {
 public:
  SweptGrid(const Box& bounds, double cell) : low_(bounds.low), inverse_cell_(1.0 / cell) {}

  void Sort(std::vector<Vec3>& positions) {
    order_.resize(positions.size());
    for (size_t i = 0; i < positions.size(); ++i) order_[i] = {Key(positions[i]), positions[i]};
    std::sort(order_.begin(), order_.end(), [](const Entry& a, const Entry& b) {
      if (a.key != b.key) return a.key < b.key;
      const Vec3 &p = a.position, &q = b.position;
      return p.x != q.x ? p.x < q.x : p.y != q.y ? p.y < q.y : p.z < q.z;
    });
    for (size_t i = 0; i < positions.size(); ++i) positions[i] = order_[i].position;
    runs_ = {};
  }

  // Calls visit(j) for each position in the cells around that of position i. REQUIRES: Sort was called, i ascends.
  template <typename Visitor>
  void ForEachNear(size_t i, const Visitor& visit) {
    const uint64_t key = order_[i].key;
    size_t row = 0;
    for (int dz = -1; dz <= 1; ++dz) {
      for (int dy = -1; dy <= 1; ++dy) {
        const uint64_t center =
            key + (static_cast<uint64_t>(dz) << (2 * kAxisBits)) + (static_cast<uint64_t>(dy) << kAxisBits);
        Run& run = runs_[row++];
        while (run.begin < order_.size() && order_[run.begin].key < center - 1) ++run.begin;
        run.end = std::max(run.end, run.begin);
        while (run.end < order_.size() && order_[run.end].key <= center + 1) ++run.end;
        for (size_t j = run.begin; j < run.end; ++j) visit(j);
      }
    }
  }

 private:
  static constexpr int kAxisBits = 21;
  struct Entry {
    uint64_t key;
    Vec3 position;
  };
  struct Run {
    size_t begin = 0;
    size_t end = 0;
  };

  // Cells are counted from 2, so that those around a cell have keys of their own.
  uint64_t Key(const Vec3& p) const {
    uint64_t key = 0;
    for (int axis = 2; axis >= 0; --axis) {
      const double cell = std::max(0.0, (p[axis] - low_[axis]) * inverse_cell_);
      key = (key << kAxisBits) + std::min<uint64_t>(static_cast<uint64_t>(cell) + 2, (1u << kAxisBits) - 3);
    }
    return key;
  }

  Vec3 low_;
  double inverse_cell_;
  std::vector<Entry> order_;
  std::array<Run, 9> runs_{};
};

// The push that positions around `p` give it. A border of an open surface mirrors them: without their images, the
// points would be driven against it.
class Push {
 public:
  Push(const Surface& surface, double reach) : bounds_(surface.bounds()), reach_(reach) {
    for (int axis = 0; axis < 3; ++axis) open_[static_cast<size_t>(axis)] = surface.is_open(axis);
  }

  void Start(const Vec3& p) {
    p_ = p;
    sum_ = {};
    mirror_count_ = 0;
    for (int axis = 0; axis < 3; ++axis) {
      if (!open_[static_cast<size_t>(axis)]) continue;
      if (p[axis] - bounds_.low[axis] < reach_) AddMirror(axis, bounds_.low[axis]);
      if (bounds_.high[axis] - p[axis] < reach_) AddMirror(axis, bounds_.high[axis]);
    }
  }

  void Add(const Vec3& q, bool same_point) {
    if (!same_point) AddOne(q);
    for (size_t m = 0; m < mirror_count_; ++m) {
      Vec3 image = q;
      image[mirrors_[m].axis] = 2.0 * mirrors_[m].at - q[mirrors_[m].axis];
      AddOne(image);
    }
  }

  const Vec3& sum() const { return sum_; }

 private:
  struct Mirror {
    int axis;
    double at;
  };

  void AddMirror(int axis, double at) { mirrors_[mirror_count_++] = {axis, at}; }

  // (1 - d / reach)^2 in the direction away from q: smooth at the reach, finite at d = 0.
  void AddOne(const Vec3& q) {
    const Vec3 away = p_ - q;
    const double squared = Dot(away, away);
    if (squared >= reach_ * reach_ || squared == 0.0) return;
    const double distance = std::sqrt(squared);
    const double closeness = 1.0 - distance / reach_;
    sum_ += (closeness * closeness / distance) * away;
  }

  Box bounds_;
  double reach_;
  std::array<bool, 3> open_{};
  Vec3 p_;
  Vec3 sum_;
  std::array<Mirror, 6> mirrors_{};
  size_t mirror_count_ = 0;
};

Vec3 Move(const Surface& surface, const Vec3& from, const Vec3& push, double spacing) {
  const double length = Norm(push);
  if (length == 0.0) return from;
  const double move = std::min(kStep * length, kMaxMove) * spacing;
  return surface.ProjectWithin(from + (move / length) * push);
}

}  // namespace

void Relax(const Surface& surface, double area, std::vector<Vec3>& positions) {
  // The distance of neighbors in a hexagonal lattice of that density.
  const double spacing = std::sqrt(2.0 / std::numbers::sqrt3 * area / static_cast<double>(positions.size()));
  const double reach = kReach * spacing;
  SweptGrid grid(surface.bounds(), reach);
  Push push(surface, reach);
  std::vector<Vec3> moved(positions.size());
  for (int round = 0; round < kRounds; ++round) {
    grid.Sort(positions);
    for (size_t i = 0; i < positions.size(); ++i) {
      push.Start(positions[i]);
      grid.ForEachNear(i, [&](size_t j) { push.Add(positions[j], i == j); });
      moved[i] = Move(surface, positions[i], push.sum(), spacing);
    }
    positions.swap(moved);
  }
}

}  // namespace curv
