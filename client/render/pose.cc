#include "client/render/pose.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>

#include "absl/strings/str_cat.h"
#include "client/neighbors/scaled_positions.h"
#include "client/render/camera.h"

namespace curv {
namespace {

constexpr double kLeastMean = 0.1, kOpenMean = 0.5, kAlongAxis = 0.9;
constexpr double kFlatRatio = 3.0, kTallerRatio = 1.1, kSeenRatio = 1.1;
constexpr int kMirrorCells = 16;
constexpr double kMirroredShare = 0.5;
constexpr double kAzimuthStep = 45.0;
constexpr double kOpenElevation = 45.0;

bool IsFinite(const Vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

// The finite points, in a length unit of their own, and the unit normals of them; zero for one that has none.
struct Cloud {
  std::vector<Vec3> positions;
  std::vector<Vec3> normals;
  Vec3 middle;
  Vec3 extent;
  Vec3 mean_normal;
};

Cloud MakeCloud(const std::vector<Vec3>& positions, const std::vector<Vec3>& normals) {
  Cloud cloud;
  size_t with_normal = 0;
  for (size_t i = 0; i < positions.size(); ++i) {
    if (!IsFinite(positions[i])) continue;
    cloud.positions.push_back(positions[i]);
    const double length = i < normals.size() ? Norm(normals[i]) : 0.0;
    const bool has_normal = std::isfinite(length) && length > 0.0;
    cloud.normals.push_back(has_normal ? (1.0 / length) * normals[i] : Vec3{});
    cloud.mean_normal += cloud.normals.back();
    with_normal += has_normal ? 1 : 0;
  }
  if (cloud.positions.empty()) return cloud;
  cloud.mean_normal = (1.0 / static_cast<double>(std::max<size_t>(1, with_normal))) * cloud.mean_normal;
  ScaleToUnit(cloud.positions);
  Vec3 low = cloud.positions.front(), high = low;
  for (const Vec3& p : cloud.positions) {
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], p[axis]);
      high[axis] = std::max(high[axis], p[axis]);
    }
  }
  cloud.middle = 0.5 * (low + high);
  cloud.extent = high - low;
  return cloud;
}

double Largest(const Vec3& v) { return std::max({v.x, v.y, v.z}); }

// Returns whether half of the cells that hold a point, or have one in their mirror image along the axis, do both.
bool IsMirrored(const Cloud& cloud, int axis) {
  constexpr int kSide = kMirrorCells;
  std::vector<uint8_t> seen(size_t{kSide} * kSide * kSide);
  const double largest = Largest(cloud.extent);
  const auto cell = [&](double offset) {
    return static_cast<size_t>(std::clamp(static_cast<int>((offset / largest + 0.5) * kSide), 0, kSide - 1));
  };
  for (const Vec3& p : cloud.positions) {
    Vec3 from = p - cloud.middle;
    for (const uint8_t side : {uint8_t{1}, uint8_t{2}}) {
      seen[(cell(from.x) * kSide + cell(from.y)) * kSide + cell(from.z)] |= side;
      from[axis] = -from[axis];
    }
  }
  const auto both = std::count(seen.begin(), seen.end(), uint8_t{3});
  const auto any = static_cast<ptrdiff_t>(seen.size()) - std::count(seen.begin(), seen.end(), uint8_t{0});
  return static_cast<double>(both) >= kMirroredShare * static_cast<double>(any);
}

void ChooseUp(const Cloud& cloud, Pose& pose) {
  const auto choose = [&](char axis, const char* reason) {
    pose.up_axis = axis;
    pose.reason = reason;
  };
  const Vec3& extent = cloud.extent;
  const double length = Norm(cloud.mean_normal);
  if (length >= kLeastMean && cloud.mean_normal.z >= kAlongAxis * length) return choose('z', "where it is open");
  if (length >= kLeastMean && cloud.mean_normal.y >= kAlongAxis * length) return choose('y', "where it is open");
  const bool has_normals = std::any_of(cloud.normals.begin(), cloud.normals.end(),
                                       [](const Vec3& n) { return n.x != 0.0 || n.y != 0.0 || n.z != 0.0; });
  if (!has_normals && kFlatRatio * extent.z <= std::min(extent.x, extent.y)) return choose('z', "it lies flat");
  if (!has_normals && kFlatRatio * extent.y <= std::min(extent.x, extent.z)) return choose('y', "it lies flat");
  const bool mirrored_y = IsMirrored(cloud, 1), mirrored_z = IsMirrored(cloud, 2);
  if (mirrored_y != mirrored_z) return choose(mirrored_y ? 'z' : 'y', "across its mirror image");
  if (mirrored_y) return choose('z', "as nothing says otherwise");
  if (extent.y >= kTallerRatio * extent.z) return choose('y', "it is taller that way");
  choose('z', extent.z >= kTallerRatio * extent.y ? "it is taller that way" : "as nothing says otherwise");
}

View ViewOf(const Pose& pose) { return *MakeView(absl::StrCat(pose.azimuth, ":", pose.elevation), pose.up_axis); }

// Returns how many points are seen from outside: those that face the viewer with nothing before them.
size_t CountSeen(const Cloud& cloud, const View& view) {
  // Cells as wide as several points, so that the front has no holes.
  const auto side =
      static_cast<size_t>(std::clamp(std::sqrt(static_cast<double>(cloud.positions.size())) / 3, 4.0, 96.0));
  const double reach = Norm(cloud.extent);
  const auto cell_of = [&](const Vec3& turned) {
    const auto at = [&](double offset) {
      return std::min(side - 1, static_cast<size_t>(std::max(0.0, (offset / reach + 0.5) * static_cast<double>(side))));
    };
    return at(turned.x) * side + at(turned.y);
  };
  std::vector<double> front(side * side, -std::numeric_limits<double>::infinity());
  for (const Vec3& p : cloud.positions) {
    const Vec3 turned = view.Turn(p - cloud.middle);
    double& depth = front[cell_of(turned)];
    depth = std::max(depth, turned.z);
  }
  const double behind = 3.0 * reach / static_cast<double>(side);
  size_t seen = 0;
  for (size_t i = 0; i < cloud.positions.size(); ++i) {
    if (Dot(cloud.normals[i], view.toward) <= 0.0) continue;
    const Vec3 turned = view.Turn(cloud.positions[i] - cloud.middle);
    seen += turned.z >= front[cell_of(turned)] - behind ? 1 : 0;
  }
  return seen;
}

void ChooseSide(const Cloud& cloud, Pose& pose) {
  const double above = pose.up_axis == 'y' ? cloud.mean_normal.y : cloud.mean_normal.z;
  if (above >= kOpenMean) pose.elevation = kOpenElevation;
  const double usual = pose.azimuth;
  double most = kSeenRatio * static_cast<double>(CountSeen(cloud, ViewOf(pose)));
  for (int step = 1; step < 8; ++step) {
    Pose other = pose;
    other.azimuth = std::fmod(usual + step * kAzimuthStep, 360.0);
    const auto seen = static_cast<double>(CountSeen(cloud, ViewOf(other)));
    if (seen <= most) continue;
    most = seen;
    pose.azimuth = other.azimuth;
  }
}

}  // namespace

Pose ChoosePose(const std::vector<Vec3>& positions, const std::vector<Vec3>& normals, std::optional<char> up_axis) {
  const Cloud cloud = MakeCloud(positions, normals);
  Pose pose;
  if (up_axis.has_value()) pose = {.up_axis = *up_axis, .reason = "as it was asked for"};
  if (cloud.positions.empty() || Largest(cloud.extent) == 0.0) return pose;
  if (!up_axis.has_value()) ChooseUp(cloud, pose);
  ChooseSide(cloud, pose);
  return pose;
}

}  // namespace curv
