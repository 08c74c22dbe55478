#include "client/cli/usage/option_conflicts.h"

#include <algorithm>
#include <cstdint>
#include <initializer_list>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "client/cli/result_columns.h"
#include "client/io/text.h"

namespace curv {
namespace {

// The numbers of neighbors whose estimates a sample of the cloud can judge.
constexpr uint32_t kLeastJudged = 16, kMostJudged = 2048;
constexpr uint32_t kJudgedJetDegree = 4;

constexpr char kStandardErrors[] = "standard_errors";

bool IsAmong(Estimator estimator, std::initializer_list<Estimator> estimators) {
  return std::find(estimators.begin(), estimators.end(), estimator) != estimators.end();
}

bool IsAsked(const EstimateOptions& options, const char* quantity) {
  return std::find(options.quantities.begin(), options.quantities.end(), quantity) != options.quantities.end();
}

std::string CountText(const char* with) {
  return absl::StrCat("must be from ", kLeastJudged, " to ", kMostJudged, with);
}

bool IsJudged(uint32_t count) { return count >= kLeastJudged && count <= kMostJudged; }

// What a sample of the cloud must be able to judge, because `cause` asks for it.
void CheckJudged(const EstimateOptions& options, const std::string& cause) {
  if (IsAmong(options.estimator,
              {Estimator::kHexagram, Estimator::kUniform, Estimator::kIndependent, Estimator::kDelaunay})) {
    throw CLI::ValidationError("--estimator",
                               absl::StrCat(std::string(EstimatorName(options.estimator)), " does not go with ", cause,
                                            ", which needs auto, avg-hexagram, normal-regression, jet or aso"));
  }
  const uint32_t degree = options.jet_degree.value_or(options.automatic_scale ? kJudgedJetDegree : 2);
  if (options.estimator == Estimator::kJetFitting && degree != kJudgedJetDegree) {
    throw CLI::ValidationError("--jet-degree",
                               absl::StrCat("is ", degree, "; ", cause, " needs --jet-degree=", kJudgedJetDegree));
  }
}

// The flag that asks for a quantity, by its name in the contract.
const char* FlagOf(const QuantityFlags& quantities, const char* quantity) {
  const bool is_also = std::find(quantities.also.begin(), quantities.also.end(), quantity) != quantities.also.end();
  return is_also ? "--also" : "--quantities";
}

void CheckStandardErrors(const EstimateOptions& options, const QuantityFlags& quantities) {
  if (!options.neighbor_counts.empty()) {
    throw CLI::ValidationError("--k", "is a list; standard_errors needs one number of neighbors, or --k=auto");
  }
  if (options.radius.has_value()) {
    throw CLI::ValidationError("--radius", "does not go with standard_errors, which needs --k");
  }
  CheckJudged(options, kStandardErrors);
  if (options.automatic_scale.has_value()) return;
  if (!IsJudged(options.neighbor_count)) {
    throw CLI::ValidationError(
        "--k", absl::StrCat("is ", options.neighbor_count, "; it ", CountText(" where standard_errors are asked for")));
  }
  if (options.estimator == Estimator::kAlgebraicShapeOperator && !options.project) {
    throw CLI::ValidationError(FlagOf(quantities, kStandardErrors),
                               absl::StrCat(kStandardErrors, " needs --project with --estimator=aso"));
  }
}

void CheckNeighborList(const EstimateOptions& options) {
  if (IsAmong(options.estimator,
              {Estimator::kHexagram, Estimator::kUniform, Estimator::kIndependent, Estimator::kDelaunay,
               Estimator::kJetFitting, Estimator::kAlgebraicShapeOperator, Estimator::kAuto})) {
    throw CLI::ValidationError("--k",
                               absl::StrCat("is a list, which needs --estimator=avg-hexagram or normal-regression; ",
                                            std::string(EstimatorName(options.estimator)), " takes one number"));
  }
}

}  // namespace

void CheckConflicts(const EstimateOptions& options, const QuantityFlags& quantities) {
  const bool is_automatic = options.automatic_scale.has_value() || options.estimator == Estimator::kAuto;
  if (!options.neighbor_counts.empty()) CheckNeighborList(options);
  if (options.automatic_scale.has_value()) CheckJudged(options, "--k=auto");
  if (is_automatic && !options.automatic_scale.has_value() && !IsJudged(options.neighbor_count)) {
    throw CLI::ValidationError(
        "--k", absl::StrCat("is ", options.neighbor_count, "; it ", CountText(" with --estimator=auto")));
  }
  if (IsAsked(options, kStandardErrors)) CheckStandardErrors(options, quantities);
  for (const char* chosen : {"chosen_neighbor_count", "estimator_weights"}) {
    if (is_automatic || !IsAsked(options, chosen)) continue;
    throw CLI::ValidationError(FlagOf(quantities, chosen), absl::StrCat(chosen, " needs --auto or --k=auto"));
  }
  if (options.reject_opposed_normals && !AskForCurvature(options.quantities)) {
    throw CLI::ValidationError("--on-opposed-normals", "reject needs a quantity of curvature among --quantities");
  }
}

void CheckNormalCount(const std::string& prefix, const NormalFlags& flags) {
  uint32_t count;
  if (flags.k == "auto" || !ParseNumber(flags.k, count)) return;
  // As many as the polynomial has coefficients; without a method the server takes jets of degree 2.
  const uint32_t least = flags.method == "pca" || flags.method == "jet-1" ? 4 : flags.method == "jet-4" ? 15 : 6;
  if (count >= least) return;
  throw CLI::ValidationError(
      absl::StrCat("--", prefix, "k"),
      absl::StrCat("is ", count, "; with --", prefix, "method=", flags.method.empty() ? "jet-2" : flags.method,
                   flags.method.empty() ? ", the default," : "", " it must be at least ", least));
}

}  // namespace curv
