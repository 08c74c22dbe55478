#include "client/cli/tiles/tile_calls.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/cord.h"
#include "client/cli/result_columns.h"

namespace curv {
namespace {

constexpr char kServerError[] = "curv.tiles/server-error";

TileAnswer AnswerOf(CurvatureResult result, bool keep_radius) {
  TileAnswer answer;
  answer.radii = result.radius;
  answer.is_unusable.reserve(result.status.size());
  for (const uint8_t status : result.status) {
    answer.is_unusable.push_back(status == static_cast<uint8_t>(PointStatus::kInvalidInput));
  }
  for (const EstimateWarning& warning : result.summary.warnings) {
    answer.has_opposed_normals = answer.has_opposed_normals || warning.code == "OPPOSED_NORMALS";
    answer.has_normals_off_surface = answer.has_normals_off_surface || warning.code == "NORMALS_OFF_SURFACE";
  }
  if (!keep_radius) result.radius.clear();
  answer.columns = ColumnsOf(std::move(result));
  return answer;
}

// Whether an estimate draws random numbers by the points' ids. Else these decide between equal distances alone, for
// which it is enough that the points come in the order of their ids.
bool DrawsByIds(Estimator estimator) {
  switch (estimator) {
    case Estimator::kAvgHexagram:
    case Estimator::kHexagram:
    case Estimator::kJetFitting:
    case Estimator::kAlgebraicShapeOperator:
    case Estimator::kNormalRegression:
    case Estimator::kDelaunay:
      return false;
    default:
      return true;
  }
}

}  // namespace

TileEstimator EstimatorOn(const Connection& connection, const EstimateOptions& options, double reach_factor,
                          const std::stop_token& stop) {
  EstimateOptions asked = options;
  std::vector<std::string>& quantities = asked.quantities;
  const bool keep_radius =
      quantities.empty() || std::find(quantities.begin(), quantities.end(), "radius") != quantities.end();
  if (!keep_radius) quantities.emplace_back("radius");
  return [&connection, &stop, asked, keep_radius, reach_factor](
             const FloatArrays& cloud, const std::vector<uint32_t>& queries) -> absl::StatusOr<TileAnswer> {
    std::vector<PointRole> roles(cloud.ids.size(), PointRole::kHalo);
    for (const uint32_t query : queries) roles[query] = PointRole::kQuery;
    CloudView view = CloudView(cloud.positions, cloud.normals).WithRoles(roles);
    if (DrawsByIds(asked.estimator)) view = view.WithIds(cloud.ids);
    EstimateOptions options = asked;
    // So that also what lies between positions, as the targets of hexagrams do, is the same from whichever origin.
    if (cloud.spacing > 0.0) options.lattice = PositionLattice{.spacing = cloud.spacing, .origin = {}};
    absl::StatusOr<CurvatureResult> result = connection.client().Estimate(view, options, {nullptr, stop});
    absl::Status status = result.status();
    if (status.ok() && result->summary.reach_factor.value_or(HUGE_VAL) > reach_factor) {
      status = absl::FailedPreconditionError(
          "the server's estimates look further than the plan took them to: plan again with a curv of its version");
    }
    if (!status.ok()) {
      status.SetPayload(kServerError, absl::Cord("1"));
      return status;
    }
    return AnswerOf(*std::move(result), keep_radius);
  };
}

bool IsServerError(const absl::Status& status) { return status.GetPayload(kServerError).has_value(); }

}  // namespace curv
