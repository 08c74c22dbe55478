#include "client/io/binary.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <type_traits>
#include <variant>

namespace curv {
namespace {

// Rows that are taken apart at a time, so that they are read from memory once.
constexpr size_t kBlockRows = 4096;

template <typename T>
T SwapBytes(T value) {
  auto bytes = std::bit_cast<std::array<char, sizeof(T)>>(value);
  std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<T>(bytes);
}

}  // namespace

void AppendStrided(const char* first, size_t count, size_t stride, bool swap, Column& column) {
  std::visit(
      [&](auto& values) {
        using T = typename std::decay_t<decltype(values)>::value_type;
        const size_t old_size = values.size();
        values.resize(old_size + count);
        T* out = values.data() + old_size;
        for (size_t i = 0; i < count; ++i) std::memcpy(out + i, first + i * stride, sizeof(T));
        if (!swap) return;
        for (size_t i = 0; i < count; ++i) out[i] = SwapBytes(out[i]);
      },
      column.values);
}

ScalarKind KindOfScalar(size_t bytes, bool is_float, bool is_signed) {
  if (is_float) return bytes == 4 ? ScalarKind::kFloat32 : ScalarKind::kFloat64;
  switch (bytes) {
    case 1:
      return is_signed ? ScalarKind::kInt8 : ScalarKind::kUint8;
    case 2:
      return is_signed ? ScalarKind::kInt16 : ScalarKind::kUint16;
    case 4:
      return is_signed ? ScalarKind::kInt32 : ScalarKind::kUint32;
    default:
      return ScalarKind::kFloat64;
  }
}

void AppendRows(std::string_view rows, size_t count, size_t row_bytes, std::span<const RowField> fields, bool swap) {
  for (const RowField& field : fields) {
    std::visit([&](auto& values) { values.reserve(values.size() + count); }, field.column->values);
  }
  for (size_t begin = 0; begin < count; begin += kBlockRows) {
    const size_t block = std::min(kBlockRows, count - begin);
    const char* first = rows.data() + begin * row_bytes;
    for (const RowField& field : fields) AppendStrided(first + field.offset, block, row_bytes, swap, *field.column);
  }
}

}  // namespace curv
