#include "core/job/scale_fields.h"

#include <algorithm>
#include <utility>
#include <variant>

#include "core/scale/automatic.h"

namespace curvd {

ScaleFields::ScaleFields(const EstimatorOptions& options) : points_(options.scale_count()), marks_(points_.size()) {
  for (size_t scale = 0; scale < options.scale_count(); ++scale) options_.push_back(options.AtScale(scale));
}

std::vector<PointCurvature*> ScaleFields::Places(size_t scale) {
  std::vector<PointCurvature*> places;
  for (; scale < count(); ++scale) places.push_back(points_[scale].data());
  return places;
}

absl::Status ScaleFields::Allocate(size_t point_count) {
  for (PageArray<PointCurvature>& points : points_) {
    auto made = PageArray<PointCurvature>::Create(point_count);
    if (!made.ok()) return made.status();
    points = *std::move(made);
  }
  return absl::OkStatus();
}

void ScaleFields::Fill(size_t first, size_t last, PointStatus status) {
  for (size_t scale = 0; scale < count(); ++scale) {
    PointCurvature* const points = points_[scale].data();
    std::fill(points + first, points + std::min(last, points_[scale].size()), Undefined(scale, status));
  }
}

size_t ScaleFields::FirstServed(size_t point_count) const {
  size_t scale = 0;
  while (scale < count() && point_count < LeastPoints(options_[scale])) ++scale;
  return scale;
}

void ScaleFields::RefuseAll(size_t scale, const SpatialIndex& index) {
  const PointSet& set = index.point_set();
  for (size_t leaf = 0; leaf < index.leaf_count(); ++leaf) {
    for (int i = 0; i < index.LeafPoints(leaf); ++i) {
      const int32_t rank = index.positions(leaf).id[i];
      if (!set.is_query(rank)) continue;
      points_[scale][set.slot_of(rank)] = Undefined(scale, PointStatus::kTooFewNeighbors);
    }
  }
}

void ScaleFields::Refuse(size_t scale, size_t slot, PointStatus status,
                         std::array<uint64_t, kPointStatusEnd>& status_counts) {
  for (; scale < count(); ++scale) {
    PointCurvature& point = points_[scale][slot];
    --status_counts[static_cast<size_t>(point.status)];
    ++status_counts[static_cast<size_t>(status)];
    const float radius = point.radius;
    point = UndefinedCurvature(status);
    point.radius = radius;
  }
}

absl::Status ScaleFields::MakeMarks(size_t scale, const SpatialIndex& index) {
  for (; scale < count(); ++scale) {
    absl::StatusOr<SeamMarks> marks = SeamMarks::Create(index.group_count());
    if (!marks.ok()) return marks.status();
    marks_[scale] = *std::move(marks);
  }
  return absl::OkStatus();
}

const SeamMarks* ScaleFields::ShownSeam() const {
  for (const SeamMarks& marks : marks_) {
    if (marks.bytes() > 0 && marks.ShowSeam()) return &marks;
  }
  return nullptr;
}

size_t ScaleFields::bytes() const {
  size_t bytes = 0;
  for (const PageArray<PointCurvature>& points : points_) bytes += points.bytes();
  for (const SeamMarks& marks : marks_) bytes += marks.bytes();
  return bytes;
}

PointCurvature ScaleFields::Undefined(size_t scale, PointStatus status) const {
  PointCurvature point = UndefinedCurvature(status);
  if (const auto* radius = std::get_if<NeighborRadius>(&options_[scale].neighborhood)) {
    point.radius = static_cast<float>(radius->radius);
  }
  return point;
}

}  // namespace curvd
