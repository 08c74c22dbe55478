#include "client/cli/tiles/tile_calls.h"

#include <algorithm>
#include <utility>

#include "absl/strings/cord.h"
#include "client/cli/result_columns.h"

namespace curv {
namespace {

constexpr char kServerError[] = "curv.tiles/server-error";

template <typename Values>
Values Pick(const Values& values, const std::vector<uint32_t>& rows) {
  Values picked;
  picked.reserve(rows.size());
  for (const uint32_t row : rows) picked.push_back(values[row]);
  return picked;
}

TileAnswer AnswerOf(CurvatureResult result, const std::vector<uint32_t>& queries, bool keep_radius) {
  TileAnswer answer;
  answer.radii = Pick(result.radius, queries);
  answer.is_unusable.reserve(queries.size());
  for (const uint32_t query : queries) {
    answer.is_unusable.push_back(result.status[query] == static_cast<uint8_t>(PointStatus::kInvalidInput));
  }
  for (const EstimateWarning& warning : result.summary.warnings) {
    answer.has_opposed_normals = answer.has_opposed_normals || warning.code == "OPPOSED_NORMALS";
  }
  if (!keep_radius) result.radius.clear();
  for (Column& column : ColumnsOf(std::move(result))) {
    answer.columns.push_back(
        {column.name,
         std::visit([&](const auto& values) { return ColumnValues(Pick(values, queries)); }, column.values)});
  }
  return answer;
}

}  // namespace

TileEstimator EstimatorOn(const Connection& connection, const EstimateOptions& options, const std::stop_token& stop) {
  EstimateOptions asked = options;
  std::vector<std::string>& quantities = asked.quantities;
  const bool keep_radius =
      quantities.empty() || std::find(quantities.begin(), quantities.end(), "radius") != quantities.end();
  if (!keep_radius) quantities.emplace_back("radius");
  return [&connection, &stop, asked, keep_radius](const FloatArrays& cloud,
                                                  const std::vector<uint32_t>& queries) -> absl::StatusOr<TileAnswer> {
    absl::StatusOr<CurvatureResult> result =
        connection.client().Estimate(CloudView(cloud.positions, cloud.normals), asked, {nullptr, stop});
    if (!result.ok()) {
      absl::Status status = result.status();
      status.SetPayload(kServerError, absl::Cord("1"));
      return status;
    }
    return AnswerOf(*std::move(result), queries, keep_radius);
  };
}

bool IsServerError(const absl::Status& status) { return status.GetPayload(kServerError).has_value(); }

}  // namespace curv
