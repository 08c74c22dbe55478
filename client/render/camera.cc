#include "client/render/camera.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "client/io/text.h"

namespace curv {
namespace {

struct NamedView {
  std::string_view name;
  double azimuth;
  double elevation;
};

constexpr NamedView kNamedViews[] = {{"three-quarter", 35, 25}, {"front", 0, 0}, {"right", 90, 0},  {"back", 180, 0},
                                     {"left", 270, 0},          {"top", 0, 90},  {"bottom", 0, -90}};

// In degrees; false if the text names no view.
bool ParseAngles(std::string_view name, double& azimuth, double& elevation) {
  for (const NamedView& view : kNamedViews) {
    if (view.name != name) continue;
    azimuth = view.azimuth;
    elevation = view.elevation;
    return true;
  }
  const size_t colon = name.find(':');
  return colon != std::string_view::npos && ParseNumber(name.substr(0, colon), azimuth) &&
         ParseNumber(name.substr(colon + 1), elevation) && std::isfinite(azimuth) && std::abs(elevation) <= 90.0;
}

}  // namespace

absl::StatusOr<View> MakeView(std::string_view name, char up_axis) {
  double azimuth, elevation;
  if (!ParseAngles(name, azimuth, elevation)) {
    return absl::InvalidArgumentError(absl::StrCat("view is \"", std::string(name), "\": it must be ", kViewNames,
                                                   " in degrees, elevation from -90 to 90"));
  }
  constexpr double kDegree = std::numbers::pi / 180.0;
  const double ca = std::cos(azimuth * kDegree), sa = std::sin(azimuth * kDegree);
  const double ce = std::cos(elevation * kDegree), se = std::sin(elevation * kDegree);
  // For z up: at azimuth 0 the viewer stands at -y and has +x to the right.
  View view{.right = {ca, sa, 0}, .up = {se * -sa, se * ca, ce}, .toward = {ce * sa, ce * -ca, se}};
  if (up_axis == 'y') {
    for (Vec3* v : {&view.right, &view.up, &view.toward}) *v = {v->x, v->z, -v->y};
  }
  return view;
}

}  // namespace curv
