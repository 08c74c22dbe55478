#include "client/tiles/input_points.h"

#include <algorithm>
#include <memory>
#include <variant>

#include "absl/strings/str_cat.h"
#include "client/io/blocks/table_blocks.h"
#include "client/io/oriented_cloud.h"

namespace curv {

std::string ColumnText(const Column& column) {
  static constexpr const char* kWords[] = {"int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64"};
  return absl::StrCat(column.name, " ", kWords[static_cast<size_t>(column.kind())]);
}

ReadingBounds ReadingBounds::For(uint64_t memory_bytes) {
  // A table takes up to four times the bytes of its text, and the text itself is there too.
  return {.block_bytes = std::clamp<uint64_t>(memory_bytes / 64, 1 << 16, 8 << 20), .most_bytes = memory_bytes / 8};
}

absl::Status ForEachBlock(const std::vector<TileInput>& inputs, const ReadingBounds& bounds,
                          const std::function<absl::Status(const PointBlock& block)>& visit) {
  uint64_t first_id = 0;
  for (size_t input = 0; input < inputs.size(); ++input) {
    const absl::StatusOr<std::unique_ptr<TableBlocks>> blocks =
        TableBlocks::Open(inputs[input].path, inputs[input].format, bounds.block_bytes, bounds.most_bytes);
    if (!blocks.ok()) return blocks.status();
    while (true) {
      const absl::StatusOr<PointTable> table = (*blocks)->Next();
      if (!table.ok()) return table.status();
      if (table->size() == 0) break;
      if (absl::Status status = visit({input, first_id, &*table}); !status.ok()) return status;
      first_id += table->size();
    }
  }
  return absl::OkStatus();
}

absl::Status ForEachPlannedBlock(const TilePlan& plan, const ReadingBounds& bounds,
                                 const std::function<absl::Status(const PointBlock& block)>& visit) {
  for (const TileInput& input : plan.inputs) {
    const absl::StatusOr<InputFile> file = InputFile::Open(input.path);
    if (!file.ok()) return absl::FailedPreconditionError(file.status().message());
    if (file->stamp() == input.stamp) continue;
    return absl::FailedPreconditionError(
        absl::StrCat(input.path, " has changed since it was planned: plan again, into another directory"));
  }
  return ForEachBlock(plan.inputs, bounds, visit);
}

absl::Status ExtractPoints(const PointBlock& block, std::vector<TilePoint>& points, bool& is_double) {
  const absl::StatusOr<OrientedCloud> cloud = ExtractCloud(*block.table);
  if (!cloud.ok()) return cloud.status();
  is_double = std::holds_alternative<PackedCloud<double>>(*cloud);
  points.resize(block.table->size());
  std::visit(
      [&](const auto& packed) {
        for (size_t i = 0; i < points.size(); ++i) {
          TilePoint& point = points[i];
          for (size_t axis = 0; axis < 3; ++axis) {
            point.position[axis] = packed.positions[3 * i + axis];
            point.normal[axis] = static_cast<float>(packed.normals[3 * i + axis]);
          }
          point.id = block.first_id + i;
        }
      },
      *cloud);
  return absl::OkStatus();
}

}  // namespace curv
