#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/estimators/strategies.h"
#include "core/job/estimation_job.h"
#include "server/call/wire_strategies.h"
#include "tests/fault/curvd_child.h"
#include "tests/fault/soak_load.h"

namespace curvd {
namespace {

// Above this size only the default estimator: the soak is to change its load often.
constexpr size_t kAllEstimatorsUpTo = 200'000;

SoakCase MakeCase(std::shared_ptr<const FaultCloud> cloud, const Strategy& strategy, WorkerPool& pool) {
  EstimatorOptions options;
  options.estimator = strategy.name;
  SoakCase made{std::move(cloud), {}, {}};
  made.header.set_point_count(made.cloud->size());
  made.header.mutable_options()->set_estimator(WireEstimator(strategy));
  const auto result = EstimateCurvature(made.cloud->ToCloud(), options, pool);
  if (!result.ok()) Fail(absl::StrCat("the direct computation fails: ", std::string(result.status().message())));
  made.expected = ResultDigest::Of(result->field);
  return made;
}

// Clouds with duplicates as scanners write them, and worse.
std::vector<std::shared_ptr<const FaultCloud>> HostileClouds(size_t points) {
  FaultCloud equal(points, 11), no_returns(points, 12), outlier(points, 13);
  std::fill(equal.positions.begin(), equal.positions.end(), 1.0f);
  std::fill(no_returns.positions.begin(), no_returns.positions.begin() + no_returns.positions.size() / 6 * 3, 0.0f);
  outlier.positions[0] = 1e30f;
  return {std::make_shared<const FaultCloud>(std::move(equal)),
          std::make_shared<const FaultCloud>(std::move(no_returns)),
          std::make_shared<const FaultCloud>(std::move(outlier))};
}

}  // namespace

std::vector<SoakCase> MakeSoakCases(size_t max_points) {
  constexpr size_t kHostilePoints = 20'000;
  constexpr size_t kSizes[] = {1, 2, 5, 17, 50, 300, 1'000, 5'000, 20'000, 100'000, 200'000, 1'000'000, 5'000'000};
  WorkerPool pool(2);
  std::vector<SoakCase> cases;
  const auto add = [&](const std::shared_ptr<const FaultCloud>& cloud) {
    for (const Strategy* strategy : Strategies()) {
      if (cloud->size() <= kAllEstimatorsUpTo || strategy == Strategies().front()) {
        cases.push_back(MakeCase(cloud, *strategy, pool));
      }
    }
  };
  for (const size_t size : kSizes) {
    if (size > max_points) break;
    add(std::make_shared<const FaultCloud>(size, size));
    if (size != kHostilePoints) continue;
    for (const auto& cloud : HostileClouds(size)) add(cloud);
  }
  return cases;
}

}  // namespace curvd
