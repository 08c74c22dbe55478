#include "client/cli/normals/normals_text.h"

#include <nlohmann/json.hpp>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/numbers.h"

namespace curv {
namespace {

std::string MethodText(const NormalsReport& report) {
  if (!report.method.has_value()) return absl::StrCat(CountOf(report.turned, "normal"), " turned");
  std::string text = absl::StrCat("normals by ", std::string(NormalMethodName(*report.method)));
  if (report.neighbor_count > 0) absl::StrAppend(&text, " of ", CountOf(report.neighbor_count, "point"));
  if (report.noise.has_value()) absl::StrAppendFormat(&text, ", noise %.3g", *report.noise);
  if (report.noisy_part.has_value()) {
    const NoisyNormals& noisy = *report.noisy_part;
    absl::StrAppendFormat(&text, " (the noisiest %.0f %% by %s of %s", 100.0 * noisy.share,
                          NormalMethodName(noisy.method), CountOf(noisy.neighbor_count, "point"));
    if (noisy.noise.has_value()) absl::StrAppendFormat(&text, ", noise %.3g", *noisy.noise);
    absl::StrAppend(&text, ")");
  }
  return text;
}

}  // namespace

std::string NormalsText(const NormalsReport& report) {
  std::string text = MethodText(report);
  if (report.pieces > 0) {
    absl::StrAppend(&text, "; ", CountOf(report.pieces, "piece"), ", ",
                    report.closed_pieces == report.pieces ? "closed" : absl::StrCat(report.closed_pieces, " closed"));
  }
  if (report.inner_walls > 0) absl::StrAppend(&text, ", ", report.inner_walls, " the inside of a wall");
  if (report.certificate.has_value()) absl::StrAppendFormat(&text, ", certificate %.2g", *report.certificate);
  if (report.repaired > 0) absl::StrAppend(&text, ", ", CountOf(report.repaired, "normal"), " repaired");
  if (report.missing > 0) {
    absl::StrAppend(&text, "; ", CountOf(report.missing, "point"), report.missing == 1 ? " has none" : " have none");
  }
  return text;
}

nlohmann::ordered_json NormalsJson(const NormalsReport& report) {
  nlohmann::ordered_json json;
  if (report.method.has_value()) {
    json["method"] = NormalMethodName(*report.method);
    if (report.neighbor_count > 0) json["neighbor_count"] = report.neighbor_count;
    if (report.noise.has_value()) json["noise"] = *report.noise;
    if (report.noisy_part.has_value()) {
      const NoisyNormals& noisy = *report.noisy_part;
      nlohmann::ordered_json& part = json["noisy_part"];
      part = {{"method", NormalMethodName(noisy.method)}, {"neighbor_count", noisy.neighbor_count}};
      if (noisy.noise.has_value()) part["noise"] = *noisy.noise;
      part["share"] = noisy.share;
    }
  } else {
    json["turned"] = report.turned;
  }
  json["missing"] = report.missing;
  json["pieces"] = report.pieces;
  json["closed_pieces"] = report.closed_pieces;
  json["closed_area_share"] = report.closed_area_share;
  json["repaired"] = report.repaired;
  json["inner_walls"] = report.inner_walls;
  if (report.certificate.has_value()) json["certificate"] = *report.certificate;
  if (report.max_trusted_certificate.has_value()) json["max_trusted_certificate"] = *report.max_trusted_certificate;
  json["doubtful"] = report.doubtful;
  return json;
}

nlohmann::ordered_json WarningsJson(const EstimateSummary& summary) {
  nlohmann::ordered_json warnings = nlohmann::ordered_json::array();
  for (const EstimateWarning& warning : summary.warnings) {
    warnings.push_back({{"code", warning.code},
                        {"message", warning.message},
                        {"points", warning.points},
                        {"pairs", warning.pairs},
                        {"opposed_pairs", warning.opposed_pairs},
                        {"flipped_patches", warning.flipped_patches}});
  }
  return warnings;
}

}  // namespace curv
