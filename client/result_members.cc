#include <array>

#include "client/curvature_client.h"

namespace curv {

std::span<const ResultMember> ResultMembers() {
  using R = CurvatureResult;
  static constexpr std::array<ResultMember, 21> kMembers = {{
      {"normal", 3, true, &R::normals},
      {"mean_curvature", 1, false, &R::mean},
      {"gaussian_curvature", 1, false, &R::gaussian},
      {"k1", 1, false, &R::k1},
      {"k2", 1, false, &R::k2},
      {"d1", 3, false, &R::d1},
      {"d2", 3, false, &R::d2},
      {"radius", 1, false, &R::radius},
      {"normal_residual", 1, true, &R::normal_residual},
      {"normal_variance_ratio", 1, true, &R::normal_variance_ratio},
      {"shape_index", 1, false, &R::shape_index},
      {"curvedness", 1, false, &R::curvedness},
      {"mean_curvature_standard_error", 1, false, &R::mean_standard_error},
      {"k1_standard_error", 1, false, &R::k1_standard_error},
      {"k2_standard_error", 1, false, &R::k2_standard_error},
      {"chosen_neighbor_count", 1, false, &R::chosen_neighbor_count},
      {"avg_hexagram_weight", 1, false, &R::avg_hexagram_weight},
      {"normal_regression_weight", 1, false, &R::normal_regression_weight},
      {"jet_weight", 1, false, &R::jet_weight},
      {"aso_weight", 1, false, &R::aso_weight},
      {"normal_curvature", 1, false, &R::normal_curvature},
  }};
  return kMembers;
}

}  // namespace curv
