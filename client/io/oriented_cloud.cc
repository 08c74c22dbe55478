#include "client/io/oriented_cloud.h"

#include <algorithm>
#include <array>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "client/io/text.h"

namespace curv {
namespace {

using Axes = std::array<const Column*, 3>;

Axes FindAxes(const PointTable& table, const std::array<const char*, 3>& names) {
  return {table.Find(names[0]), table.Find(names[1]), table.Find(names[2])};
}

bool IsComplete(const Axes& axes) {
  return std::none_of(axes.begin(), axes.end(), [](const Column* column) { return column == nullptr; });
}

// Of the first columns, as a message may show them.
std::string NamesOf(const PointTable& table) {
  constexpr size_t kMaxNames = 30;
  const size_t count = std::min(kMaxNames, table.columns().size());
  std::string names = absl::StrJoin(table.columns().begin(), table.columns().begin() + static_cast<ptrdiff_t>(count),
                                    " ", [](std::string* out, const Column& c) { out->append(Printable(c.name)); });
  if (count < table.columns().size()) absl::StrAppend(&names, " and ", table.columns().size() - count, " more");
  return names;
}

bool FitsFloat(const Column* column) {
  switch (column->kind()) {
    case ScalarKind::kInt32:
    case ScalarKind::kUint32:
    case ScalarKind::kFloat64:
      return false;
    default:
      return true;
  }
}

template <typename Scalar>
std::vector<Scalar> Interleave(const Axes& axes) {
  std::vector<Scalar> packed(3 * axes[0]->size());
  for (size_t axis = 0; axis < 3; ++axis) {
    std::visit(
        [&](const auto& values) {
          for (size_t i = 0; i < values.size(); ++i) packed[3 * i + axis] = static_cast<Scalar>(values[i]);
        },
        axes[axis]->values);
  }
  return packed;
}

}  // namespace

absl::StatusOr<OrientedCloud> ExtractCloud(const PointTable& table) {
  const Axes positions = FindAxes(table, {"x", "y", "z"});
  const Axes normals = FindAxes(table, {"nx", "ny", "nz"});
  if (!IsComplete(positions)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "the file has no complete positions: x, y and z are needed, it has the columns: ", NamesOf(table)));
  }
  if (!IsComplete(normals)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "the file has no normals: nx, ny and nz are needed, it has the columns: ", NamesOf(table),
        ". Curvature needs an outward normal at every point, because its sign and the surface's orientation come from "
        "them. Estimate normals with a consistent orientation first and save them with the points, for example with "
        "CloudCompare (Edit > Normals > Compute, orientation by minimum spanning tree), with Open3D "
        "(estimate_normals, then orient_normals_consistent_tangent_plane), or with PCL (NormalEstimation with the "
        "scanner's viewpoint)"));
  }
  if (std::all_of(positions.begin(), positions.end(), FitsFloat)) {
    return OrientedCloud(PackedCloud<float>{Interleave<float>(positions), Interleave<float>(normals)});
  }
  return OrientedCloud(PackedCloud<double>{Interleave<double>(positions), Interleave<double>(normals)});
}

}  // namespace curv
