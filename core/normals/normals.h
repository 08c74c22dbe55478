// What becomes of the normals of a cloud: each point's, and what can be said of all of them.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/base/page_array.h"
#include "core/estimators/curvature_field.h"
#include "core/normals/normal_options.h"

namespace curvd {

// A point's normal and its quality. All values are NaN unless status is kOk; quality is NaN for normals that were
// given.
struct PointNormal {
  std::array<float, 3> normal;  // of unit length
  float residual;               // root of the mean squared distance of the neighbors from the fit, over their radius
  float
      variance_ratio;  // least variance of the neighbors' positions over the middle one: 0 a plane, 1 a line or a ball
  // kOk, or why there is none:
  // - kTooFewNeighbors: fewer than kMinNeighborCount within the radius, or the point lies far away from all of them,
  // - kDegenerateArea: the neighbors coincide,
  // - kSingularFit: they lie on a line, or fix no polynomial,
  // - kInvalidInput: the point was not usable,
  // - kOutlier: the estimate of curvature found that it lies off the surface.
  PointStatus status;
};

// Every column of normals, with offsets in PointNormal; as kColumns has them of curvature.
inline constexpr std::array kNormalColumns = {
    Column{"status", ColumnType::kUint8, 1, offsetof(PointNormal, status)},
    Column{"normal", ColumnType::kFloat32, 3, offsetof(PointNormal, normal)},
    Column{"normal_residual", ColumnType::kFloat32, 1, offsetof(PointNormal, residual)},
    Column{"normal_variance_ratio", ColumnType::kFloat32, 1, offsetof(PointNormal, variance_ratio)},
};

// In the order of the points in the cloud; of those that get a result.
using NormalField = PageArray<PointNormal>;

// A certificate above this says that normals point to both sides of a closed surface, whatever the noise.
inline constexpr double kMaxTrustedCertificate = 0.25;
// Above this, sides cancel, or the normals point inward, unless the surface is open. Where a cloud has parts of unlike
// noise, no comparison with other neighborhoods vouches for them: the quiet part has the same in both. With one noise,
// bowls and waves whose noise is a spacing or more come to 2 as well, and have the right sides.
inline constexpr double kMaxPlausibleCertificate = 0.5;
// The most that can be trusted where the positions have noise of that standard deviation, in units of the spacing of
// the points. Where all normals were right, 0.02 was measured without noise (0.05 on shells a few spacings thin), 0.06,
// 0.12 and 0.14 with noise of 0.3, 0.7 and 1; where 2 to 5 % were turned, 0.06 to 0.12 without noise.
inline double MaxTrustedCertificate(double noise_in_spacings) {
  return std::min(0.06 + 0.18 * (1.0 - std::exp(-1.5 * noise_in_spacings)), kMaxTrustedCertificate);
}

// The most points that another number of neighbors may turn. Measured with noise of 0.3 to 1.5 spacings: 1.4 % and more
// where more than 2 % have the wrong side.
inline constexpr double kMostTurnedShare = 0.01;
// The same of thin parts, whose sides twice as many neighbors mostly tell: the share is then nearly that of the wrong
// sides. Measured: up to 0.4 % where at most 0.5 % were wrong, 0.9 % where 2.2 % were.
inline constexpr double kMostTurnedShareOfThin = 0.005;

// The most pairs along one sheet that may have opposed sides. Measured where at most 0.5 % of the points had the wrong
// side: 0.0012 and less; 0.033 where the repair had turned a part of a ball.
inline constexpr double kMostTornShare = 0.005;

// What was found out about a cloud while its normals were made.
struct NormalReport {
  // Of estimated normals: what was used, and what was found.
  std::optional<NormalMethod> method;
  // 0 for a radius. Where it was chosen automatically, points near sharp edges may have fewer.
  uint32_t neighbor_count = 0;
  // Standard deviation of the noise of positions along the normal, in the caller's length unit; where the neighborhood
  // was chosen automatically and a sample of the points could tell.
  std::optional<double> sigma;
  // How normals were made of the noisier part of the points, where there is one. Method, neighbor_count and sigma are
  // then those of the other points.
  struct NoisyPart {
    NormalMethod method;
    uint32_t neighbor_count;
    std::optional<double> sigma;
    double share;  // of the points, as a sample shows it
  };
  std::optional<NoisyPart> noisy_part;
  std::array<uint64_t, kPointStatusEnd> status_counts{};  // of the points that get a result, by PointStatus

  // Of oriented normals: how many of the points with a normal were turned; for estimated ones that says nothing.
  size_t flipped_count = 0;
  // Of consistent sides: connected pieces, how many of them are closed, and the share of the area that those have.
  size_t piece_count = 0;
  size_t closed_piece_count = 0;
  double closed_area_share = 0.0;
  // Points with a normal that the repair turned, and so saved from the wrong side.
  size_t repaired_count = 0;
  // Closed pieces that are the inside of another's wall (core/normals/orientation/hollow_walls.h): their normals point
  // inward.
  size_t inner_wall_count = 0;
  // Closed pieces within another one that is too far away to tell whether they bound a hollow in it or are bodies of
  // their own: their normals point outward.
  size_t ambiguous_piece_count = 0;
  // How much the winding number of a piece's own normals varies over its points: that of the worst piece, of those that
  // are large and closed, or were said to be, or may be thin closed ones. 0 is perfect, max_trusted_certificate the
  // most that can be trusted, 1 says that sides cancel, and 2 that the normals point inward.
  std::optional<double> certificate;
  double max_trusted_certificate = kMaxTrustedCertificate;
  // Where positions are noisy, or a part is thin: the share of the points whose normals point to the other side if they
  // are made of another number of neighbors (core/normals/trust/side_check.h).
  std::optional<double> turned_share;
  // Of estimated normals with consistent sides (core/normals/trust/side_probe.h): the share of a normal's neighbors
  // that point to the other side, in the mean, where the fit takes them for one sheet; and whether that is so much that
  // the normals are those of two sheets at once, and those of the narrow sides between them say nothing.
  std::optional<double> opposed_share;
  bool mixes_sides = false;
  // The same: the share of the pairs of neighbors along one sheet whose normals point to different sides of it; of two
  // parts of unlike noise, that of the one where it is larger.
  std::optional<double> torn_share;
  // Whether the surface came out open, and may be two sheets that lie nearer to each other than points can show: what
  // the fits leave is much, and not distributed like noise (core/normals/sheet_probe.h).
  bool may_be_closed = false;
  double most_turned_share = kMostTurnedShare;
  // Whether sides that stay are right, whatever the certificate: it varies from noise alone. With a noisy part, up to
  // kMaxPlausibleCertificate.
  bool turned_share_decides = false;
  // Whether the orientation cannot be trusted, as far as all of that tells.
  bool is_doubtful() const {
    if (ambiguous_piece_count > 0 || mixes_sides || may_be_closed) return true;
    if (torn_share.has_value() && *torn_share > kMostTornShare) return true;
    if (turned_share.has_value() && *turned_share > most_turned_share) return true;
    const bool is_plausible = !noisy_part.has_value() || certificate.value_or(0.0) <= kMaxPlausibleCertificate;
    if (turned_share.has_value() && turned_share_decides && is_plausible) return false;
    return certificate.has_value() && !(*certificate <= max_trusted_certificate);
  }
};

}  // namespace curvd
