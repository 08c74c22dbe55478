// Where the normals of a cloud come from, and to which side of its surface they point.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <variant>

namespace curv {

// The values are those of curvature.v1.NormalSource.
enum class NormalSource : uint8_t {
  kGiven = 1,     // with the cloud, outward
  kOrient = 2,    // with the cloud, up to their signs: the server turns some of them
  kEstimate = 3,  // the server makes them of the positions; the cloud has none
};

// How the server makes a normal of the positions around a point. The values are those of curvature.v1.NormalMethod.
enum class NormalMethod : uint8_t {
  kPca = 1,   // of the plane of least squares; 4 neighbors at least
  kJet1 = 2,  // of a polynomial of degree 1 over that plane; 4 neighbors at least
  kJet2 = 3,  // of degree 2; 6
  kJet4 = 4,  // of degree 4, for exact positions; 15
};

// "pca", "jet-1", "jet-2" or "jet-4".
std::string_view NormalMethodName(NormalMethod method);
// The method of that name, or nothing.
std::optional<NormalMethod> NormalMethodOf(std::string_view name);

// Normals of neighbors agree, each connected piece of the cloud for itself. Closed pieces get normals that point
// outward. Open ones keep the side that most of their area had, if normals were given; else the largest component of
// their mean normal is positive.
struct ConsistentSides {
  // The cloud covers closed surfaces, whatever holes it has: all pieces get normals that point outward.
  bool closed = false;
};
// Normals point to where the surface was seen from.
struct SidesTowardViewpoint {
  std::array<double, 3> viewpoint;  // finite
};
// The same with the viewpoints of CloudView, one for each point.
struct SidesTowardViewpoints {};
// No normal points against the direction.
struct SidesAlongDirection {
  std::array<double, 3> direction;  // finite, not zero
};

struct NormalOptions {
  // DEFAULT: kGiven, with which the other options have no effect.
  NormalSource source = NormalSource::kGiven;
  // kEstimate alone. DEFAULT: kJet2 or kJet4, whichever the positions ask for; with a neighborhood of your own, kJet2.
  std::optional<NormalMethod> method = std::nullopt;
  // kEstimate alone: points in a neighborhood, the point itself included; 0: as many as the noise of the positions asks
  // for. Not used if `radius` is set. DEFAULT: 0.
  uint32_t neighbor_count = 0;
  // kEstimate alone: radius of the neighborhoods, in the cloud's length unit. DEFAULT: none.
  std::optional<double> radius = std::nullopt;
  // kOrient and kEstimate. DEFAULT: ConsistentSides.
  std::variant<ConsistentSides, SidesTowardViewpoint, SidesTowardViewpoints, SidesAlongDirection> sides{};
};

// How normals were made where positions are much noisier than elsewhere in the cloud.
struct NoisyNormals {
  NormalMethod method;
  uint32_t neighbor_count;
  std::optional<double> noise;  // standard deviation, in the cloud's length unit
  double share;                 // of the points, 0 to 1, as a sample shows it
};

// What the server found out while it made or oriented normals.
struct NormalsReport {
  // Of estimated normals: how they were made, and of how many points; 0 for a radius.
  std::optional<NormalMethod> method = std::nullopt;
  uint32_t neighbor_count = 0;
  // Standard deviation of the noise of positions, in the cloud's length unit, where it was found.
  std::optional<double> noise = std::nullopt;
  // How normals were made of the noisier part of the points, where there is one. Method, neighbor_count and noise are
  // then those of the other points.
  std::optional<NoisyNormals> noisy_part = std::nullopt;
  uint64_t missing = 0;  // points without a normal
  uint64_t turned = 0;   // of given normals
  // Of consistent sides: connected pieces, those that are closed, and their share of the area.
  uint64_t pieces = 0;
  uint64_t closed_pieces = 0;
  double closed_area_share = 0.0;
  uint64_t repaired = 0;  // normals that neighbors had on the wrong side
  // Closed pieces that are the inside of a hollow body's wall: their normals point inward.
  uint64_t inner_walls = 0;
  // Of closed surfaces: 0 is perfect; above max_trusted_certificate sides cannot be trusted.
  std::optional<double> certificate = std::nullopt;
  std::optional<double> max_trusted_certificate = std::nullopt;
  bool doubtful = false;  // sides cannot be trusted; the summary has a warning
};

}  // namespace curv
