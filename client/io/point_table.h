// Holds a file's points in memory: named columns of equal length, in the types that the file had.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "client/io/pcd/pcd_frame.h"

namespace curv {

struct LasFrame;

// Types of a column, in the order of ColumnValues' alternatives.
enum class ScalarKind : uint8_t { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

using ColumnValues =
    std::variant<std::vector<int8_t>, std::vector<uint8_t>, std::vector<int16_t>, std::vector<uint16_t>,
                 std::vector<int32_t>, std::vector<uint32_t>, std::vector<float>, std::vector<double>>;

// Returns the bytes that one scalar takes.
size_t BytesOf(ScalarKind kind);
// Returns values of that kind, none of them so far.
ColumnValues MakeValues(ScalarKind kind);

// The most columns that the readers take. Finding a column by its name looks at one after the other: a file that names
// a million would keep a program busy for hours.
inline constexpr size_t kMaxColumns = 4096;

struct Column {
  std::string name;
  ColumnValues values;

  ScalarKind kind() const { return static_cast<ScalarKind>(values.index()); }
  size_t size() const;
  // Returns value i as a double, to which every kind converts exactly. REQUIRES: i < size().
  double At(size_t i) const;
};

// Const methods are thread-safe, others are not.
class PointTable {
 public:
  // Returns the number of points.
  size_t size() const { return columns_.empty() ? 0 : columns_.front().size(); }
  const std::vector<Column>& columns() const { return columns_; }

  // Returns the column of that name, or nullptr.
  const Column* Find(std::string_view name) const;

  // Appends a column, or replaces the one of its name in its place.
  // REQUIRES: column.size() == size(), unless the table has no other column.
  void Set(Column column);

  // Takes the columns out; the table is empty then.
  std::vector<Column> Release();

  // From where the points were seen, if the file tells: in the coordinates of x y z.
  std::optional<std::array<double, 3>> viewpoint;

  // What else the PCD file that the points come from says; a PCD file made of the table says it too.
  PcdFrame pcd;

  // What the LAS file that the points come from says beside their values; a LAS file made of the table says it too.
  // Null for other tables.
  std::shared_ptr<const LasFrame> las;

  // Tells the user what a reader left out of the table, in one sentence for each thing.
  std::vector<std::string> notes;

 private:
  std::vector<Column> columns_;
};

}  // namespace curv
