#include "client/cli/scale/scale_text.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/numbers.h"

namespace curv {
namespace {

// Those with a weight, the largest first, then the best of each estimator that has none.
std::vector<ScaleOutcome> WorthTelling(const ScaleReport& report) {
  std::vector<ScaleOutcome> told;
  for (const ScaleOutcome& outcome : report.outcomes) {
    if (outcome.share > 0.0) told.push_back(outcome);
  }
  std::stable_sort(told.begin(), told.end(),
                   [](const ScaleOutcome& a, const ScaleOutcome& b) { return a.share > b.share; });
  const size_t chosen = told.size();
  for (const ScaleOutcome& outcome : report.outcomes) {
    const auto is_same = [&](const ScaleOutcome& other) { return other.estimator == outcome.estimator; };
    const auto weighted = told.begin() + static_cast<std::ptrdiff_t>(chosen);
    if (std::any_of(told.begin(), weighted, is_same)) continue;
    const auto best = std::find_if(weighted, told.end(), is_same);
    if (best == told.end()) {
      told.push_back(outcome);
    } else if (outcome.error < best->error) {
      *best = outcome;
    }
  }
  return told;
}

std::string NameOf(const ScaleOutcome& outcome) {
  return outcome.degree == 0 ? outcome.estimator : absl::StrCat(outcome.estimator, ", degree ", outcome.degree);
}

std::string TextOf(const FittedNormals& fit) {
  return absl::StrFormat("%s of %u points", NormalMethodName(fit.method), fit.neighbor_count);
}

nlohmann::ordered_json JsonOf(const std::optional<FittedNormals>& fit) {
  if (!fit) return nullptr;
  return {{"method", NormalMethodName(fit->method)}, {"neighbor_count", fit->neighbor_count}};
}

}  // namespace

std::string ScaleText(const ScaleReport& report) {
  if (report.outcomes.empty()) return "  nothing to choose by: too few points, or none could be estimated\n";
  std::string text = absl::StrFormat("  chosen by %s, noise up to %.3g; expected error of mean_curvature:\n",
                                     CountOf(report.sampled_points, "point"), report.position_noise);
  absl::StrAppendFormat(&text, "  %-27s %5s %10s %10s %12s %8s\n", "estimator", "K", "error", "by noise",
                        "by smoothing", "weight");
  for (const ScaleOutcome& o : WorthTelling(report)) {
    absl::StrAppendFormat(&text, "  %-27s %5u %10.3g %10.3g %12.3g %6.0f %%\n", NameOf(o), o.neighbor_count, o.error,
                          o.noise, o.bias, 100.0 * o.share);
  }
  if (report.normal_noise) {
    absl::StrAppendFormat(&text, "  noise of normals: %.3g rad along each tangent\n", *report.normal_noise);
  }
  if (report.fitted_normals || report.normals_made_anew) {
    absl::StrAppend(&text, "  given normals: ",
                    report.fitted_normals ? TextOf(*report.fitted_normals) : "made of the positions", ", ",
                    report.normals_made_anew ? absl::StrCat("made anew: ", TextOf(*report.normals_made_anew))
                                             : "whose halves told their noise",
                    "\n");
  }
  return text;
}

nlohmann::ordered_json ScaleJson(const ScaleReport& report) {
  nlohmann::ordered_json outcomes = nlohmann::ordered_json::array();
  for (const ScaleOutcome& o : report.outcomes) {
    outcomes.push_back({{"estimator", o.estimator},
                        {"degree", o.degree},
                        {"neighbor_count", o.neighbor_count},
                        {"error", o.error},
                        {"noise", o.noise},
                        {"bias", o.bias},
                        {"share", o.share}});
  }
  return {{"sampled_points", report.sampled_points},
          {"position_noise", report.position_noise},
          {"normal_noise", report.normal_noise ? nlohmann::ordered_json(*report.normal_noise) : nullptr},
          {"fitted_normals", JsonOf(report.fitted_normals)},
          {"normals_made_anew", JsonOf(report.normals_made_anew)},
          {"outcomes", std::move(outcomes)}};
}

}  // namespace curv
