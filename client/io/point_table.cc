#include "client/io/point_table.h"

#include <algorithm>
#include <utility>

namespace curv {

size_t BytesOf(ScalarKind kind) {
  static constexpr size_t kBytes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return kBytes[static_cast<size_t>(kind)];
}

ColumnValues MakeValues(ScalarKind kind) {
  switch (kind) {
    case ScalarKind::kInt8:
      return std::vector<int8_t>();
    case ScalarKind::kUint8:
      return std::vector<uint8_t>();
    case ScalarKind::kInt16:
      return std::vector<int16_t>();
    case ScalarKind::kUint16:
      return std::vector<uint16_t>();
    case ScalarKind::kInt32:
      return std::vector<int32_t>();
    case ScalarKind::kUint32:
      return std::vector<uint32_t>();
    case ScalarKind::kFloat32:
      return std::vector<float>();
    case ScalarKind::kFloat64:
      break;
  }
  return std::vector<double>();
}

size_t Column::size() const {
  return std::visit([](const auto& typed) { return typed.size(); }, values);
}

double Column::At(size_t i) const {
  return std::visit([i](const auto& typed) { return static_cast<double>(typed[i]); }, values);
}

const Column* PointTable::Find(std::string_view name) const {
  const auto found = std::find_if(columns_.begin(), columns_.end(), [&](const Column& c) { return c.name == name; });
  return found == columns_.end() ? nullptr : &*found;
}

void PointTable::Set(Column column) {
  const auto found =
      std::find_if(columns_.begin(), columns_.end(), [&](const Column& c) { return c.name == column.name; });
  if (found == columns_.end()) {
    columns_.push_back(std::move(column));
  } else {
    *found = std::move(column);
  }
}

std::vector<Column> PointTable::Release() { return std::exchange(columns_, {}); }

}  // namespace curv
