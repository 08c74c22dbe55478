// Curvature of a cloud, and its normals, from a curvd server: one call on arrays.
//
//   auto client = curv::CurvatureClient::Connect("localhost:50061");
//   auto result = (*client)->Estimate(curv::CloudView(positions, normals), {});
//
// Without normals, the server makes them:
//   options.normals.source = curv::NormalSource::kEstimate;
//   result = (*client)->Estimate(curv::CloudView(positions), options);
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "client/automatic_scale.h"
#include "client/connect_options.h"
#include "client/io/point_status.h"
#include "client/normal_options.h"

namespace grpc {
class Channel;
}  // namespace grpc

namespace curv {

// What a point is to the estimate. The values are those of curvature.v1.PointRole.
enum class PointRole : uint8_t {
  kQuery = 1,  // gets a result
  kHalo = 2,   // is a neighbor of others, and gets no result
};

// Somebody else's points: x y z of each, its normal if there is one, and where it was seen from if that is known; all
// in float or all in double. Coordinates far from zero (georeferenced scans) keep their precision in double only.
class CloudView {
 public:
  // REQUIRES: the arrays outlive the view.
  explicit CloudView(std::span<const float> positions) : CloudView(positions, {}) {}
  explicit CloudView(std::span<const double> positions) : CloudView(positions, {}) {}
  CloudView(std::span<const float> positions, std::span<const float> normals)
      : positions_(std::as_bytes(positions)), normals_(std::as_bytes(normals)), scalar_bytes_(sizeof(float)) {}
  CloudView(std::span<const double> positions, std::span<const double> normals)
      : positions_(std::as_bytes(positions)), normals_(std::as_bytes(normals)), scalar_bytes_(sizeof(double)) {}

  // The same points with a viewpoint each, for SidesTowardViewpoints. REQUIRES: the type is that of the positions; the
  // array outlives the view.
  CloudView SeenFrom(std::span<const float> viewpoints) const { return WithViewpoints(std::as_bytes(viewpoints)); }
  CloudView SeenFrom(std::span<const double> viewpoints) const { return WithViewpoints(std::as_bytes(viewpoints)); }

  // The same points as a part of a larger cloud, with the id that each has in it: in any order, no two the same. A
  // point's result then does not depend on the part in which it is sent (docs/protocol.md says what else that takes).
  // REQUIRES: the array outlives the view.
  CloudView WithIds(std::span<const uint64_t> ids) const {
    CloudView view = *this;
    view.ids_ = ids;
    return view;
  }
  // The same points, some of which get no result. REQUIRES: the array outlives the view.
  CloudView WithRoles(std::span<const PointRole> roles) const {
    CloudView view = *this;
    view.roles_ = roles;
    return view;
  }

  std::span<const uint64_t> ids() const { return ids_; }       // may be none
  std::span<const PointRole> roles() const { return roles_; }  // may be none
  // Points that get a result.
  size_t query_count() const {
    return size() - static_cast<size_t>(std::count(roles_.begin(), roles_.end(), PointRole::kHalo));
  }
  // The same points with a direction each, for the quantity normal_curvature: of any length; that of a point whose
  // direction is 0, not finite, or along the normal is NaN. REQUIRES: as above.
  CloudView Toward(std::span<const float> directions) const { return WithDirections(std::as_bytes(directions)); }
  CloudView Toward(std::span<const double> directions) const { return WithDirections(std::as_bytes(directions)); }

  std::span<const std::byte> positions() const { return positions_; }
  std::span<const std::byte> normals() const { return normals_; }        // may be none
  std::span<const std::byte> viewpoints() const { return viewpoints_; }  // may be none
  std::span<const std::byte> directions() const { return directions_; }  // may be none
  // How many of these four arrays there are.
  size_t array_count() const {
    return 1 + (normals_.empty() ? 0 : 1) + (viewpoints_.empty() ? 0 : 1) + (directions_.empty() ? 0 : 1);
  }
  bool is_double() const { return scalar_bytes_ == sizeof(double); }
  // Bytes of one position.
  size_t point_bytes() const { return 3 * scalar_bytes_; }
  // Number of whole positions.
  size_t size() const { return positions_.size() / point_bytes(); }

 private:
  CloudView WithViewpoints(std::span<const std::byte> viewpoints) const {
    CloudView view = *this;
    view.viewpoints_ = viewpoints;
    return view;
  }

  CloudView WithDirections(std::span<const std::byte> directions) const {
    CloudView view = *this;
    view.directions_ = directions;
    return view;
  }

  std::span<const std::byte> positions_;
  std::span<const std::byte> normals_;
  std::span<const std::byte> viewpoints_;
  std::span<const uint64_t> ids_;
  std::span<const PointRole> roles_;
  std::span<const std::byte> directions_;
  size_t scalar_bytes_;
};

// A grid of positions that all parts of a cloud share: each coordinate is rounded to the nearest multiple of `spacing`
// before the origin, which may be another one in each part, is subtracted.
struct PositionLattice {
  // A power of two, in the cloud's length unit.
  double spacing = 1.0;
  // Multiples of `spacing`. All positions must lie within 2^23 spacings of it, axis by axis.
  std::array<double, 3> origin{};
};

// The values are those of curvature.v1.Estimator; EstimatorOf gives also those that the contract has gained since.
enum class Estimator : uint8_t {
  kAvgHexagram = 1,
  kHexagram = 2,
  kUniform = 3,
  kIndependent = 4,
  kDelaunay = 5,
  kJetFitting = 6,
  kAlgebraicShapeOperator = 7,
  kNormalRegression = 8,
  kAuto = 9,  // those that suit the cloud, averaged; EstimateSummary::scale tells which. Mostly with automatic_scale
};

// "avg-hexagram", "hexagram", "uniform", "independent", "delaunay", "jet", "aso", "normal-regression", "auto" and
// whatever else the contract has, in its order.
std::span<const std::string_view> EstimatorNames();
// The name of an estimator; empty if the contract does not have it.
std::string_view EstimatorName(Estimator estimator);
// The estimator of that name, or nothing.
std::optional<Estimator> EstimatorOf(std::string_view name);

// "mean_curvature", "gaussian_curvature", "principal_curvatures", "principal_directions", "radius", "normals",
// "normal_quality", "shape_index", "curvedness", "standard_errors", "chosen_neighbor_count", "estimator_weights",
// "normal_curvature", and what the contract has beside them (enum Quantity).
const std::vector<std::string>& QuantityNames();
// Those of curvature that come without being asked for: the first five.
const std::vector<std::string>& DefaultQuantityNames();

// Whose work the server does first. kBySize: kInteractive up to 100,000 points, kBatch above.
enum class Priority : uint8_t { kBySize, kInteractive, kBatch };

struct EstimateOptions {
  // How a neighborhood becomes curvature. DEFAULT: kAvgHexagram.
  Estimator estimator = Estimator::kAvgHexagram;
  // Points in a neighborhood, the point itself included; not used if `radius` or `automatic_scale` is set. DEFAULT: 50.
  uint32_t neighbor_count = 50;
  // Several of them instead, in ascending order, at most 16, with one search for the largest: CurvatureResult::scales
  // has results at each. For kAvgHexagram and kNormalRegression; neighbor_count, `radius` and `automatic_scale` are not
  // used then. A server that is too old for it fails the call with UNIMPLEMENTED. DEFAULT: none.
  std::vector<uint32_t> neighbor_counts;
  // Radius of the neighborhoods instead, in the cloud's length unit. DEFAULT: none.
  std::optional<double> radius;
  // A number of neighbors that the server chooses instead, for kAuto and the estimators that it chooses among; `radius`
  // is not used then. A server that is too old for it fails the call with UNIMPLEMENTED. DEFAULT: none.
  std::optional<AutomaticScale> automatic_scale;
  // Triangles of kUniform, and at most so many of kIndependent. DEFAULT: 100.
  uint32_t triangle_count = 100;
  // Hexagrams that kAvgHexagram averages over, 1 to 4; 1 is the paper's estimator. DEFAULT: 2.
  uint32_t rotation_count = 2;
  // Of the polynomial that kJetFitting fits, 2 to 4; 4 for exact positions only. With `automatic_scale` only 4 is
  // taken. DEFAULT: none, which stands for 2, or with `automatic_scale` for 4.
  std::optional<uint32_t> jet_degree;
  // Of the polynomials that kNormalRegression fits, 1 to 3: 3 follows the surface farther, 2 takes more of the noise
  // away, and 1, fitted over space, is right for spheres, cylinders and planes at any size. DEFAULT: 3.
  uint32_t regression_degree = 3;
  // All triangles of kDelaunay count alike, as in the paper, instead of less the farther they lie from the point.
  // DEFAULT: false.
  bool even_weights = false;
  // Of kAlgebraicShapeOperator: the curvature of the surface at the place nearest to the point, in place of that of the
  // level of the fitted field through it: for noisy positions. With `automatic_scale` always. DEFAULT: false.
  bool project = false;
  // Of the random estimators. DEFAULT: 0.
  uint64_t seed = 0;
  // In [0, 1]; none: the server's default. DEFAULT: none.
  std::optional<double> average_normal_weight;
  // Where normals come from. DEFAULT: with the cloud.
  NormalOptions normals;
  // Quantities to send, of QuantityNames(), each at most once; of the others the result has empty arrays. If none is of
  // curvature, none is estimated. "standard_errors" is of kAuto, kAvgHexagram, kNormalRegression, kJetFitting of
  // degree 4, and kAlgebraicShapeOperator with project, with an automatic scale or 16 to 2,048 neighbors;
  // "chosen_neighbor_count" and "estimator_weights" take an automatic scale or kAuto; "normal_curvature" a direction.
  // DEFAULT: empty, which asks for DefaultQuantityNames(), and for the normals unless they are given.
  std::vector<std::string> quantities;
  // Of the quantity normal_curvature, one direction for all points: finite, of any length but 0. DEFAULT: none; the
  // cloud then has one for each point (CloudView::Toward).
  std::optional<std::array<double, 3>> curvature_direction;
  // What the positions are relative to. Curvature does not depend on it. DEFAULT: zero.
  std::array<double, 3> origin{};
  // Where positions are put, so that the parts of a cloud agree on them. DEFAULT: where the server puts them.
  std::optional<PositionLattice> lattice;
  // Give unusable points a status, instead of refusing the cloud. DEFAULT: refuse.
  bool skip_invalid = false;
  // Refuse a cloud whose normals point to opposite sides of one surface, instead of giving the points around such
  // places a status and the summary a warning. DEFAULT: false.
  bool reject_opposed_normals = false;
  // Changes when the result comes, never what it is. DEFAULT: kBySize.
  Priority priority = Priority::kBySize;
  // For the server's log; at most 128 bytes of printable ASCII. DEFAULT: empty.
  std::string request_tag;
  // For the whole call with its retries. DEFAULT: no limit.
  absl::Duration timeout = absl::InfiniteDuration();
  // Times the cloud is sent at most, when servers are unavailable. DEFAULT: 6, over about 8 seconds.
  int max_attempts = 6;
  // After which a call gives up if no server has ever answered this client, when each was tried. DEFAULT: 1.5 s.
  absl::Duration connect_timeout = absl::Milliseconds(1500);
  // Bytes of a message's arrays, unless the server allows less. DEFAULT: 256 KiB, whose copies stay in the cache.
  size_t chunk_bytes = 256 << 10;
};

// What is known about a running call. Counts restart when the cloud is sent again.
struct EstimateProgress {
  enum class Phase : uint8_t {
    kConnecting,
    kSending,
    kQueued,
    kIndexing,
    kMakingNormals,
    kOrienting,
    kEstimating,
    kReceiving
  };
  Phase phase = Phase::kConnecting;
  int attempt = 1;      // counted from 1
  uint64_t points = 0;  // of the cloud
  uint64_t points_sent = 0;
  uint64_t points_estimated = 0;  // as far as the server tells
  uint64_t points_received = 0;   // results
};

struct EstimateCallbacks {
  // Told about progress on the calling thread; must not block. What it throws ends the call and reaches the caller.
  std::function<void(const EstimateProgress&)> on_progress;
  // Ends the call with CANCELLED.
  std::stop_token stop;
};

// What is wrong with a cloud that was estimated nevertheless: show it to whoever reads the results.
struct EstimateWarning {
  // "OPPOSED_NORMALS", "DOUBTFUL_ORIENTATION", "COARSE_POSITIONS", "NO_RESULTS", "NORMALS_OFF_SURFACE", "OUTLIERS", or
  // what the contract has gained since (WarningCode).
  std::string code;
  std::string message;         // what was found and what to do
  uint64_t points = 0;         // without results because of it
  uint64_t pairs = 0;          // of a point and one of its six nearest neighbors
  uint64_t opposed_pairs = 0;  // of them, those on one surface with normals to its opposite sides
  // Parts of surfaces, of ten points and more, that must be turned for their normals to agree with their largest part.
  uint64_t flipped_patches = 0;
};

// What the server said about the whole cloud.
struct EstimateSummary {
  uint64_t points = 0;
  // By PointStatus; [0]: those without a word here. With neighbor_counts, a point counts once for each of them.
  std::array<uint64_t, kStatusWords.size()> status_counts{};
  uint64_t normals_rescaled = 0;  // normals that were not of unit length
  // Wall-clock seconds of the server's phases.
  double receive_seconds = 0.0;
  double queue_seconds = 0.0;
  double index_seconds = 0.0;
  double normals_seconds = 0.0;      // making them
  double orientation_seconds = 0.0;  // turning them
  double estimate_seconds = 0.0;
  double send_seconds = 0.0;
  uint64_t peak_bytes = 0;
  std::vector<EstimateWarning> warnings;
  std::optional<NormalsReport> normals;  // none where they were given
  std::optional<ScaleReport> scale;      // of kAuto, automatic_scale, or standard_errors
  // How far from a point its estimate looked at most, in units of its radius. A point of a part of a cloud has the
  // result that it has in the whole one if no place that was left out, and may hold points, is within that and one part
  // in a million more. None where there is no such factor.
  std::optional<double> reach_factor;
  std::string request_id;  // as in the server's log
  int attempts = 1;
};

// A column of results that CurvatureResult has no member for.
struct NamedColumn {
  std::string name;  // as in the contract's ResultChunk
  size_t width = 1;  // scalars a point
  std::variant<std::vector<float>, std::vector<uint8_t>> values;
};

// One entry a point (three for d1, d2 and normals), in the order of the cloud; where it has roles, one for each query.
// NaN where status is not kOk, save `radius`, which is there wherever there is a neighborhood, and normals, which are
// NaN where there are none. Empty for quantities that were not asked for.
struct CurvatureResult {
  std::vector<float> mean;  // (k1 + k2) / 2; 1 / r on a ball with outward normals
  std::vector<float> gaussian;
  std::vector<float> k1;  // <= k2
  std::vector<float> k2;
  std::vector<float> d1;       // x y z of the unit direction of k1
  std::vector<float> d2;       // x y z of the unit direction of k2; d1 x d2 is along the normal
  std::vector<float> radius;   // of the neighborhood
  std::vector<float> normals;  // x y z of the unit normal in use
  // Of estimated normals: how far the neighbors lie from the fit, over their radius, and how little they tell of their
  // plane: 0 for a plane, 1 for a line or a ball.
  std::vector<float> normal_residual;
  std::vector<float> normal_variance_ratio;
  std::vector<float> shape_index;  // -1 a cup, -0.5 a rut, 0 a saddle, 0.5 a ridge, 1 a cap; NaN also on a plane
  std::vector<float> curvedness;   // sqrt((k1^2 + k2^2) / 2)
  // Nine in ten of the intervals of 1.645 standard errors to either side of mean, k1 and k2 hold the truth. NaN where
  // the cloud is too small to tell.
  std::vector<float> mean_standard_error;
  std::vector<float> k1_standard_error;
  std::vector<float> k2_standard_error;
  // Of an automatic scale or kAuto: points in a neighborhood, in the weighted mean; and how much each estimator counts,
  // in all 1.
  std::vector<float> chosen_neighbor_count;
  std::vector<float> avg_hexagram_weight;
  std::vector<float> normal_regression_weight;
  std::vector<float> jet_weight;
  std::vector<float> aso_weight;
  std::vector<float> normal_curvature;  // k1 cos^2 + k2 sin^2 of the direction's angle to d1 in the tangent plane
  std::vector<uint8_t> status;          // values of PointStatus
  std::vector<NamedColumn> others;      // what else was asked for, in the order of the contract
  EstimateSummary summary;
  // With neighbor_counts, results at each of them, in their order, each with the bytes of a call with that count alone;
  // of the members above, only `summary`, and those that belong to normals, are then not empty. They have no summary.
  std::vector<CurvatureResult> scales;
  uint32_t neighbor_count = 0;  // of one of `scales`
};

// A member of CurvatureResult with the floats of one column of the contract.
struct ResultMember {
  std::string_view name;  // as in the contract's ResultChunk
  size_t width;           // scalars a point
  bool is_of_normals;     // the same at each of several neighbor counts
  std::vector<float> CurvatureResult::*values;
};
// All of them: normals, then the others in the order of the contract.
std::span<const ResultMember> ResultMembers();

// What a server is and accepts.
struct ServerInfo {
  std::string version;
  std::string cpu_kind;
  uint32_t worker_threads = 0;
  std::vector<std::string> estimators;
  uint64_t max_points = 0;
  uint64_t max_chunk_bytes = 0;
  uint32_t max_neighbor_count = 0;
  uint64_t memory_bytes = 0;  // 0: not limited
  uint32_t max_streams = 0;
  std::string health;  // of the curvature service: "SERVING", "NOT_SERVING", ...
  // What its clock said as it answered, to the second; none of servers that do not tell.
  std::optional<absl::Time> date;
};

// The machine-readable reason that the server gave for an error ("CHUNK_OUT_OF_ORDER"), or "" if it gave none.
std::string ErrorReason(const absl::Status& status);

// Thread-safe.
class CurvatureClient {
 public:
  // `servers` is HOST:PORT (or any gRPC target, such as unix:PATH), or several with commas between: replicas, each call
  // starting with another one and going on to the next when one is unavailable. Nothing is sent yet.
  // INVALID_ARGUMENT if the list is empty or an entry has no port, or one that is not from 1 to 65535, if
  // CheckConnectOptions finds something, or if a token would go to another machine in plain text.
  static absl::StatusOr<std::unique_ptr<CurvatureClient>> Connect(std::string_view servers,
                                                                  const ConnectOptions& options = {});

  // Speaks over a channel that the caller made. REQUIRES: channel is not null.
  explicit CurvatureClient(std::shared_ptr<grpc::Channel> channel);
  ~CurvatureClient();

  // Sends the cloud, waits, and returns its curvature: all of it, or an error. The server's code and message are kept;
  // the message ends with the reason and metadata that it gave. Retries while servers are UNAVAILABLE, say that waiting
  // helps, or die behind a proxy (UNKNOWN or INTERNAL without a reason): at once on the next server, then with growing
  // pauses, the cloud sent again each time. Further errors:
  // - INVALID_ARGUMENT: the arrays do not hold three scalars a point, or not as many normals, viewpoints, directions,
  //   ids or roles as points, or the cloud has those that the options do not ask for, or lacks them; a quantity is
  //   unknown or given twice.
  // - UNIMPLEMENTED: the server is too old to make or orient normals, or to know of ids, roles, lattices or
  //   neighbor_counts.
  // - DEADLINE_EXCEEDED, CANCELLED: timeout, stop.
  // - INTERNAL: the server's answer has gaps, wrong lengths or no summary.
  absl::StatusOr<CurvatureResult> Estimate(const CloudView& cloud, const EstimateOptions& options,
                                           const EstimateCallbacks& callbacks = {}) const;

  // Asks the first server that answers. `timeout` is for each.
  absl::StatusOr<ServerInfo> GetServerInfo(absl::Duration timeout) const;

  // Asks the first server that answers for its health alone, which needs no token: "SERVING", "NOT_SERVING", ...
  // `timeout` is for each.
  absl::StatusOr<std::string> GetHealth(absl::Duration timeout) const;

 private:
  class Channels;
  explicit CurvatureClient(std::unique_ptr<Channels> channels);
  template <typename Answer, typename Ask>
  absl::StatusOr<Answer> AskAny(Ask ask, absl::Duration timeout) const;

  std::unique_ptr<Channels> channels_;
};

}  // namespace curv
