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

Axes FindAxes(const PointTable& table, const std::array<std::string, 3>& names) {
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
  if (!IsComplete(axes)) return {};
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

// The columns that a call needs.
struct CloudColumns {
  Axes positions{}, normals{}, viewpoints{}, directions{};
};

template <typename Scalar>
PackedCloud<Scalar> Pack(const CloudColumns& columns) {
  return {Interleave<Scalar>(columns.positions), Interleave<Scalar>(columns.normals),
          Interleave<Scalar>(columns.viewpoints), Interleave<Scalar>(columns.directions)};
}

// The columns NAMEx NAMEy NAMEz or NAME_x NAME_y NAME_z.
absl::StatusOr<Axes> FindDirections(const PointTable& table, const std::string& name) {
  for (const char* separator : {"", "_"}) {
    const std::string prefix = absl::StrCat(name, separator);
    const Axes axes =
        FindAxes(table, {absl::StrCat(prefix, "x"), absl::StrCat(prefix, "y"), absl::StrCat(prefix, "z")});
    if (IsComplete(axes)) return axes;
  }
  return absl::InvalidArgumentError(absl::StrCat("the file has no directions: ", name, "x, ", name, "y and ", name,
                                                 "z are needed, it has the columns: ", NamesOf(table)));
}

}  // namespace

absl::StatusOr<OrientedCloud> ExtractCloud(const PointTable& table, const CloudNeeds& needs) {
  CloudColumns columns;
  columns.positions = FindAxes(table, {"x", "y", "z"});
  if (needs.normals) columns.normals = FindAxes(table, {"nx", "ny", "nz"});
  if (!IsComplete(columns.positions)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "the file has no complete positions: x, y and z are needed, it has the columns: ", NamesOf(table)));
  }
  if (needs.normals && !IsComplete(columns.normals)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "the file has no normals: nx, ny and nz are needed, it has the columns: ", NamesOf(table),
        ". Curvature needs a normal at every point, whose side tells its sign. curv normals makes them of the "
        "positions and writes them into a file; curv estimate --normals=estimate makes them on the way, but "
        "not in tiles"));
  }
  const auto names = needs.viewpoints ? FindViewpoints(table) : std::nullopt;
  if (needs.viewpoints && !names.has_value()) {
    return absl::InvalidArgumentError(
        absl::StrCat("the file does not tell where points were seen from: vp_x, vp_y and vp_z are needed, it has the "
                     "columns: ",
                     NamesOf(table)));
  }
  if (names.has_value()) columns.viewpoints = FindAxes(table, *names);
  if (!needs.directions.empty()) {
    const absl::StatusOr<Axes> directions = FindDirections(table, needs.directions);
    if (!directions.ok()) return directions.status();
    columns.directions = *directions;
  }
  if (std::all_of(columns.positions.begin(), columns.positions.end(), FitsFloat)) {
    return OrientedCloud(Pack<float>(columns));
  }
  return OrientedCloud(Pack<double>(columns));
}

std::optional<std::array<std::string, 3>> FindViewpoints(const PointTable& table) {
  for (const char* prefix : {"vp_", "viewpoint_", "sensor_", "scanner_"}) {
    const std::array<std::string, 3> names = {absl::StrCat(prefix, "x"), absl::StrCat(prefix, "y"),
                                              absl::StrCat(prefix, "z")};
    if (IsComplete(FindAxes(table, names))) return names;
  }
  return std::nullopt;
}

}  // namespace curv
