// Where the normals of a cloud come from, and to which side of its surface they point: plain values with defaults,
// checked by Validate.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <variant>

#include "absl/status/status.h"
#include "core/estimators/options.h"

namespace curvd {

enum class NormalSource : uint8_t {
  kGiven,     // as they come with the cloud
  kOrient,    // as they come with the cloud, up to the sign
  kEstimate,  // from the positions; normals that come with the cloud are not looked at
};

// How a normal is made of the positions in a neighborhood.
enum class NormalMethod : uint8_t {
  kPca,   // that of the plane of least squares: the direction in which the neighbors spread least
  kJet1,  // that of a polynomial of degree 1 as height over that plane, at the point
  kJet2,  // of degree 2
  kJet4,  // of degree 4
};

// The word for a method in files and messages: "pca", "jet-1", "jet-2", "jet-4".
std::string_view NormalMethodName(NormalMethod method);
// The degree of the polynomial; 0 for kPca.
int JetDegree(NormalMethod method);

// The number of neighbors is found from the noise of the positions (core/normals/normal_pilot.h), one for all points.
struct AutoNeighborhood {};

// Normals of neighbors agree, each connected piece for itself. A closed piece gets normals that point outward. An open
// one keeps the side that most of its area had, if normals were given; else the largest component of its mean normal
// is positive. Where that leaves sides that no closed surface has, but others would fit one, those are taken
// (core/normals/orientation/side_repair.h).
struct ConsistentSides {
  // Whether the cloud is known to be of closed surfaces, whatever holes it has: every piece then gets normals that
  // point outward, and a certificate. DEFAULT: what the sum of a piece's normals says.
  bool closed = false;
};
// Each normal points to the side from which the surface is seen from `viewpoint`, in the coordinates of the input.
struct SidesTowardViewpoint {
  std::array<double, 3> viewpoint;
};
// The same from a viewpoint for each point, in the order of the input; the array outlives the job.
struct SidesTowardViewpoints {
  std::span<const std::array<double, 3>> viewpoints;
};
// No normal points against `direction`, of any length but 0.
struct SidesAlongDirection {
  std::array<double, 3> direction;
};

struct NormalOptions {
  NormalSource source = NormalSource::kGiven;  // DEFAULT: given; the options below then have no effect
  // kEstimate alone. DEFAULT: chosen with the neighborhood if that is automatic, else kJet2.
  std::optional<NormalMethod> method;
  // kEstimate alone. A count must be no less than the method has coefficients. DEFAULT: automatic.
  std::variant<AutoNeighborhood, NeighborCount, NeighborRadius> neighborhood{};
  // kOrient and kEstimate. DEFAULT: ConsistentSides.
  std::variant<ConsistentSides, SidesTowardViewpoint, SidesTowardViewpoints, SidesAlongDirection> sides{};
  // Whether an estimate hands out the normals in use as well, with their quality, at 24 bytes a point. DEFAULT: no.
  bool returns_normals = false;
  // Most points that one neighborhood may hold, as in EstimatorOptions. DEFAULT: 10,000.
  uint32_t max_neighbor_count = 10'000;

  // INVALID_ARGUMENT naming field, value and limit if a field is out of its range, or if there are not as many
  // viewpoints as points.
  absl::Status Validate(size_t point_count) const;
};

// The fewest neighbors from which the method makes a normal.
uint32_t LeastNeighborCount(NormalMethod method);

}  // namespace curvd
