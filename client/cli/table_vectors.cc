#include "client/cli/table_vectors.h"

#include <type_traits>

#include "client/orient/orient_normals.h"

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

size_t OrientTable(PointTable& table, int threads) {
  const Orientation orientation = OrientNormals(VectorsOf(table, ""), VectorsOf(table, "n"), threads);
  for (const char* name : {"nx", "ny", "nz"}) {
    Column column = *table.Find(name);
    Negate(orientation.flip, column);
    table.Set(std::move(column));
  }
  return orientation.flipped;
}

}  // namespace curv
