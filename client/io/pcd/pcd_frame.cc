#include "client/io/pcd/pcd_frame.h"

#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "client/io/point_table.h"

namespace curv {

std::string NoteOnFrame(const PointTable& table, std::string_view extension) {
  if (extension == ".pcd") return "";
  std::vector<std::string> lost;
  if (table.viewpoint.has_value() || table.pcd.rotation != PcdFrame().rotation) {
    const std::array<double, 3> v = table.viewpoint.value_or(std::array<double, 3>{});
    lost.push_back(absl::StrFormat("the viewpoint %.10g,%.10g,%.10g", v[0], v[1], v[2]));
  }
  if (table.pcd.height > 1) {
    lost.push_back(absl::StrCat("the grid of ", table.pcd.width, " x ", table.pcd.height, " points"));
  }
  if (lost.empty()) return "";
  return absl::StrCat("left out ", absl::StrJoin(lost, " and "), ", for which only .pcd has a place");
}

}  // namespace curv
