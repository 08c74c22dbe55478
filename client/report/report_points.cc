#include "client/report/report_points.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "client/io/point_status.h"
#include "client/render/framing.h"
#include "client/report/quantize.h"
#include "client/surfaces/vec3.h"

namespace curv {
namespace {

constexpr double kRadiusStepsAnOctave = 16.0;

// Three columns that are read as one vector a point.
struct VectorColumns {
  const Column* axes[3];

  Vec3 At(size_t i) const { return {axes[0]->At(i), axes[1]->At(i), axes[2]->At(i)}; }
};

std::optional<VectorColumns> FindVectors(const PointTable& table, const std::string& prefix) {
  const VectorColumns found{{table.Find(prefix + "x"), table.Find(prefix + "y"), table.Find(prefix + "z")}};
  if (found.axes[0] == nullptr || found.axes[1] == nullptr || found.axes[2] == nullptr) return std::nullopt;
  return found;
}

bool IsFinite(const Vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

// How far `value` is along the way from low to high, without overflow; 0 where they are the same.
double Share(double value, double low, double high) {
  const double width = 0.5 * high - 0.5 * low;
  return width > 0.0 ? std::clamp((0.5 * value - 0.5 * low) / width, 0.0, 1.0) : 0.0;
}

void AppendPlaces(const VectorColumns& positions, const std::vector<uint32_t>& chosen, const Bounds& bounds,
                  Payload& payload) {
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<uint16_t> places;
    places.reserve(chosen.size());
    for (const uint32_t i : chosen) {
      const Vec3 p = positions.At(i);
      const auto a = static_cast<size_t>(axis);
      places.push_back(IsFinite(p) ? static_cast<uint16_t>(
                                         std::lround(Share(p[axis], bounds.low[a], bounds.high[a]) * kLargestPlace))
                                   : kNowhere);
    }
    payload.Add(std::string(1, "xyz"[axis]), places);
  }
}

// The chosen points with finite positions, in a box whose longest side is 1.
std::vector<Vec3> ScaledPlaces(const VectorColumns& positions, const std::vector<uint32_t>& chosen,
                               const Bounds& bounds) {
  double half_side = 0.0;
  for (size_t a = 0; a < 3; ++a) half_side = std::max(half_side, 0.5 * bounds.high[a] - 0.5 * bounds.low[a]);
  if (half_side == 0.0) half_side = 1.0;
  std::vector<Vec3> scaled;
  for (const uint32_t i : chosen) {
    const Vec3 p = positions.At(i);
    if (!IsFinite(p)) continue;
    Vec3 place;
    for (int axis = 0; axis < 3; ++axis) {
      place[axis] = (0.5 * p[axis] - 0.5 * bounds.low[static_cast<size_t>(axis)]) / half_side;
    }
    scaled.push_back(place);
  }
  return scaled;
}

// Rounds radii up, so that no hole opens between splats.
double AppendRadii(const VectorColumns& positions, const std::vector<uint32_t>& chosen, const Bounds& bounds,
                   const SplatSizes& sizes, Payload& payload) {
  const std::vector<Vec3> scaled = ScaledPlaces(positions, chosen, bounds);
  std::vector<double> radii = scaled.empty() ? std::vector<double>() : DiscRadii(scaled);
  for (double& radius : radii) radius *= std::sqrt(sizes.share);
  const double largest = sizes.largest > 0.0 ? sizes.largest
                         : radii.empty()     ? 1.0
                                             : *std::max_element(radii.begin(), radii.end());
  std::vector<uint8_t> codes;
  codes.reserve(chosen.size());
  size_t next = 0;
  for (const uint32_t i : chosen) {
    const double octaves = IsFinite(positions.At(i)) ? std::log2(largest / radii[next++]) : 0.0;
    codes.push_back(static_cast<uint8_t>(std::clamp(std::floor(octaves * kRadiusStepsAnOctave), 0.0, 255.0)));
  }
  payload.Add("radius8", codes);
  return largest;
}

using DirectionCode = std::array<int8_t, 2>;

void AppendCodes(const std::string& name, const std::vector<DirectionCode>& codes, Payload& payload) {
  for (const size_t side : {size_t{0}, size_t{1}}) {
    std::vector<uint8_t> bits;
    bits.reserve(codes.size());
    for (const DirectionCode& code : codes) bits.push_back(static_cast<uint8_t>(code[side]));
    payload.Add(name + "_" + "uv"[side], bits);
  }
}

// The normals of the file; where it has none, across its directions.
bool AppendNormals(const PointTable& table, const std::vector<uint32_t>& chosen, Payload& payload) {
  const auto normals = FindVectors(table, "n"), first = FindVectors(table, "d1"), second = FindVectors(table, "d2");
  if (!normals && !(first && second)) return false;
  std::vector<DirectionCode> codes;
  codes.reserve(chosen.size());
  for (const uint32_t i : chosen) {
    codes.push_back(OctahedralCode(normals ? normals->At(i) : Cross(first->At(i), second->At(i))));
  }
  AppendCodes("normal", codes, payload);
  return true;
}

// They lie across each other, but not across the point's own normal: the estimators smooth normals first.
bool AppendDirections(const PointTable& table, const std::vector<uint32_t>& chosen,
                      const std::vector<uint8_t>& statuses, Payload& payload) {
  const auto first = FindVectors(table, "d1"), second = FindVectors(table, "d2");
  if (!first || !second) return false;
  std::vector<DirectionCode> codes;
  std::vector<uint8_t> angles;
  codes.reserve(chosen.size());
  angles.reserve(chosen.size());
  for (const uint32_t i : chosen) {
    const bool is_ok = statuses.empty() || statuses[i] == static_cast<uint8_t>(PointStatus::kOk);
    codes.push_back(OctahedralCode(is_ok ? first->At(i) : Vec3{}));
    angles.push_back(codes.back()[0] == kNoDirection ? kNoAngle
                                                     : AngleCode(OctahedralDirection(codes.back()), second->At(i)));
  }
  AppendCodes("first", codes, payload);
  payload.Add("angle", angles);
  return true;
}

}  // namespace

Bounds BoundsOf(const PointTable& table) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Bounds bounds{.low = {kInfinity, kInfinity, kInfinity}, .high = {-kInfinity, -kInfinity, -kInfinity}};
  const VectorColumns positions = *FindVectors(table, "");
  for (size_t i = 0; i < table.size(); ++i) {
    const Vec3 p = positions.At(i);
    if (!IsFinite(p)) continue;
    ++bounds.finite;
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<size_t>(axis);
      bounds.low[a] = std::min(bounds.low[a], p[axis]);
      bounds.high[a] = std::max(bounds.high[a], p[axis]);
    }
  }
  return bounds;
}

Pose PoseOf(const PointTable& table, const std::vector<uint32_t>& chosen, std::optional<char> up_axis) {
  const VectorColumns positions = *FindVectors(table, "");
  const auto normals = FindVectors(table, "n");
  std::vector<Vec3> places, sides;
  for (const uint32_t i : chosen) {
    places.push_back(positions.At(i));
    if (normals) sides.push_back(normals->At(i));
  }
  return ChoosePose(places, sides, up_axis);
}

EncodedPoints AppendPoints(const PointTable& table, const std::vector<uint32_t>& chosen, const Bounds& bounds,
                           const std::vector<uint8_t>& statuses, Payload& payload, const SplatSizes& sizes) {
  const VectorColumns positions = *FindVectors(table, "");
  EncodedPoints encoded;
  AppendPlaces(positions, chosen, bounds, payload);
  encoded.largest_radius = AppendRadii(positions, chosen, bounds, sizes, payload);
  for (const uint32_t i : chosen) encoded.nowhere += IsFinite(positions.At(i)) ? 0 : 1;
  encoded.has_normals = AppendNormals(table, chosen, payload);
  encoded.has_directions = AppendDirections(table, chosen, statuses, payload);
  return encoded;
}

}  // namespace curv
