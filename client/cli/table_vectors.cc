#include "client/cli/table_vectors.h"

#include <cstdint>
#include <type_traits>
#include <utility>

namespace curv {
namespace {

// Normals of unsigned columns cannot be negated in their type.
void Negate(const std::vector<uint8_t>& flip, Column& column) {
  std::vector<double> exact;
  std::visit(
      [&](auto& values) {
        using Scalar = typename std::decay_t<decltype(values)>::value_type;
        if constexpr (std::is_floating_point_v<Scalar>) {
          for (size_t i = 0; i < values.size(); ++i) values[i] = flip[i] != 0 ? -values[i] : values[i];
        } else {
          for (size_t i = 0; i < values.size(); ++i) exact.push_back(flip[i] != 0 ? -1.0 * values[i] : 1.0 * values[i]);
        }
      },
      column.values);
  if (!exact.empty()) column.values = std::move(exact);
}

}  // namespace

std::vector<Vec3> VectorsOf(const PointTable& table, const std::string& prefix) {
  const Column* const axes[] = {table.Find(prefix + "x"), table.Find(prefix + "y"), table.Find(prefix + "z")};
  std::vector<Vec3> vectors(table.size());
  for (size_t i = 0; i < vectors.size(); ++i) vectors[i] = {axes[0]->At(i), axes[1]->At(i), axes[2]->At(i)};
  return vectors;
}

size_t TurnTable(const std::vector<float>& normals, PointTable& table) {
  const Column* const axes[] = {table.Find("nx"), table.Find("ny"), table.Find("nz")};
  std::vector<uint8_t> flip(table.size());
  size_t flipped = 0;
  for (size_t i = 0; i < flip.size(); ++i) {
    double agreement = 0.0;
    for (size_t axis = 0; axis < 3; ++axis) agreement += axes[axis]->At(i) * normals[3 * i + axis];
    flip[i] = agreement < 0.0 ? 1 : 0;
    flipped += flip[i];
  }
  for (const char* name : {"nx", "ny", "nz"}) {
    Column column = *table.Find(name);
    Negate(flip, column);
    table.Set(std::move(column));
  }
  return flipped;
}

}  // namespace curv
