#include "client/cli/usage/flag_words.h"

#include "absl/strings/cord.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"

namespace curv {

absl::Status InFlags(const absl::Status& status, const std::string& normal_prefix) {
  const std::string normal_k = absl::StrCat("--", normal_prefix, "k");
  const std::string normal_radius = absl::StrCat("--", normal_prefix, "radius");
  const std::string remedy = absl::StrContains(status.message(), "header.normals.radius")
                                 ? absl::StrCat("use a smaller ", normal_radius, ", or ", normal_k)
                                 : "use a smaller --radius, or --k";
  // Of two that begin alike, the longer one counts.
  const std::string message =
      absl::StrReplaceAll(status.message(), {{"header.options.estimator", "--estimator"},
                                             {"header.options.neighbor_count", "--k"},
                                             {"header.options.neighbor_counts", "--k"},
                                             {"header.options.radius", "--radius"},
                                             {"header.options.automatic_scale.least_neighbor_count", "--k-range"},
                                             {"header.options.automatic_scale.most_neighbor_count", "--k-range"},
                                             {"header.options.automatic_scale.max_radius", "--max-radius"},
                                             {"header.options.triangle_count", "--triangles"},
                                             {"header.options.rotation_count", "--rotations"},
                                             {"header.options.jet_degree", "--jet-degree"},
                                             {"header.options.regression_degree", "--regression-degree"},
                                             {"header.options.project", "--project"},
                                             {"header.normals.method", absl::StrCat("--", normal_prefix, "method")},
                                             {"header.normals.neighbor_count", normal_k},
                                             {"header.normals.radius", normal_radius},
                                             {"use a smaller radius, or neighbor_count", remedy}});
  absl::Status worded(status.code(), message);
  status.ForEachPayload(
      [&worded](absl::string_view url, const absl::Cord& payload) { worded.SetPayload(url, payload); });
  return worded;
}

}  // namespace curv
