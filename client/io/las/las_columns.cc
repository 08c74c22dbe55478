#include "client/io/las/las_columns.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>

namespace curv {
namespace {

ScalarKind KindOf(const LasField& field) {
  if (field.scaling.has_value()) return ScalarKind::kFloat64;
  switch (field.type) {
    case LasType::kUint8:
      return ScalarKind::kUint8;
    case LasType::kInt8:
      return ScalarKind::kInt8;
    case LasType::kUint16:
      return ScalarKind::kUint16;
    case LasType::kInt16:
      return ScalarKind::kInt16;
    case LasType::kUint32:
      return ScalarKind::kUint32;
    case LasType::kInt32:
      return ScalarKind::kInt32;
    case LasType::kFloat32:
      return ScalarKind::kFloat32;
    default:
      return ScalarKind::kFloat64;
  }
}

// The value that a table has for a stored one.
template <typename T>
double Decode(T stored, const std::optional<LasScaling>& scaling) {
  const auto value = static_cast<double>(stored);
  if (!scaling.has_value()) return value;
  if (scaling->no_data == value) return std::numeric_limits<double>::quiet_NaN();
  return value * scaling->scale + scaling->offset;
}

// The stored value for one of a table; none if it is outside the range of T, or of the field's bits.
template <typename T>
std::optional<T> Encode(double value, const LasField& field) {
  double stored = value;
  if (field.scaling.has_value()) {
    stored = (value - field.scaling->offset) / field.scaling->scale;
    if (std::isnan(value) && field.scaling->no_data.has_value()) stored = *field.scaling->no_data;
    if (std::is_integral_v<T>) stored = std::nearbyint(stored);
  }
  if constexpr (std::is_integral_v<T>) {
    // 2^63 and 2^64 are doubles, the largest integers of 64 bits are not.
    const double end = field.bits != 0 ? std::ldexp(1.0, field.bits) : std::ldexp(1.0, std::numeric_limits<T>::digits);
    if (!(stored >= static_cast<double>(std::numeric_limits<T>::min()) && stored < end)) return std::nullopt;
    return static_cast<T>(stored);
  } else {
    if (std::is_same_v<T, float> && std::isfinite(stored) && std::abs(stored) > std::numeric_limits<float>::max()) {
      return std::nullopt;
    }
    return static_cast<T>(stored);
  }
}

bool IsSame(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

bool IsExact(uint64_t bits, bool is_signed) {
  constexpr int64_t kLargest = int64_t{1} << 53;
  if (!is_signed) return bits <= static_cast<uint64_t>(kLargest);
  const auto value = static_cast<int64_t>(bits);
  return value >= -kLargest && value <= kLargest;
}

}  // namespace

LasColumnReader::LasColumnReader(const LasField& field)
    : field_(field), column_{field.name, MakeValues(KindOf(field))} {}

void LasColumnReader::Reserve(size_t count) {
  if (field_.is_wide()) return wide_.reserve(count);
  std::visit([count](auto& values) { values.reserve(count); }, column_.values);
}

void LasColumnReader::Append(const char* records, size_t count, size_t stride) {
  const char* const first = records + field_.offset;
  if (field_.is_wide()) {
    const size_t old_size = wide_.size();
    wide_.resize(old_size + count);
    for (size_t i = 0; i < count; ++i) std::memcpy(&wide_[old_size + i], first + i * stride, sizeof(uint64_t));
    return;
  }
  WithType(field_.type, [&](auto scalar) {
    using T = decltype(scalar);
    std::visit(
        [&](auto& values) {
          using Value = typename std::decay_t<decltype(values)>::value_type;
          const auto mask = static_cast<uint8_t>((1u << field_.bits) - 1);
          for (size_t i = 0; i < count; ++i) {
            T stored;
            std::memcpy(&stored, first + i * stride, sizeof(T));
            if (field_.scaling.has_value()) {
              values.push_back(static_cast<Value>(Decode(stored, field_.scaling)));
            } else if (field_.bits == 0) {
              values.push_back(static_cast<Value>(stored));
            } else {
              values.push_back(static_cast<Value>((static_cast<uint8_t>(stored) >> field_.first_bit) & mask));
            }
          }
        },
        column_.values);
  });
}

std::vector<Column> LasColumnReader::Finish() {
  std::vector<Column> columns;
  if (!field_.is_wide()) {
    columns.push_back(std::move(column_));
    return columns;
  }
  const bool is_signed = field_.type == LasType::kInt64;
  if (std::all_of(wide_.begin(), wide_.end(), [is_signed](uint64_t bits) { return IsExact(bits, is_signed); })) {
    std::vector<double> values(wide_.size());
    for (size_t i = 0; i < wide_.size(); ++i) {
      values[i] = is_signed ? static_cast<double>(static_cast<int64_t>(wide_[i])) : static_cast<double>(wide_[i]);
    }
    columns.push_back({field_.name, std::move(values)});
    return columns;
  }
  std::vector<uint32_t> low(wide_.size()), high(wide_.size());
  for (size_t i = 0; i < wide_.size(); ++i) {
    low[i] = static_cast<uint32_t>(wide_[i]);
    high[i] = static_cast<uint32_t>(wide_[i] >> 32);
  }
  columns.push_back({field_.name + "_low", std::move(low)});
  columns.push_back({field_.name + "_high", std::move(high)});
  return columns;
}

bool Fits(const LasField& field, const Column& column) {
  bool fits = true;
  WithType(field.type, [&](auto scalar) {
    using T = decltype(scalar);
    std::visit(
        [&](const auto& values) {
          fits = std::all_of(values.begin(), values.end(), [&](auto value) {
            const std::optional<T> stored = Encode<T>(static_cast<double>(value), field);
            return stored.has_value() && IsSame(Decode(*stored, field.scaling), static_cast<double>(value));
          });
        },
        column.values);
  });
  return fits;
}

void Store(const LasField& field, const LasSource& source, size_t begin, size_t count, size_t stride, char* records) {
  char* const first = records + field.offset;
  if (source.high != nullptr) {
    const auto& low = std::get<std::vector<uint32_t>>(source.column->values);
    const auto& high = std::get<std::vector<uint32_t>>(source.high->values);
    for (size_t i = 0; i < count; ++i) {
      const uint64_t wide = (uint64_t{high[begin + i]} << 32) | low[begin + i];
      std::memcpy(first + i * stride, &wide, sizeof(wide));
    }
    return;
  }
  WithType(field.type, [&](auto scalar) {
    using T = decltype(scalar);
    const auto put = [&](size_t i, double value) {
      const T stored = Encode<T>(value * source.factor, field).value_or(T{});
      if (field.bits == 0) {
        std::memcpy(first + i * stride, &stored, sizeof(T));
      } else {
        char& byte = first[i * stride];
        byte = static_cast<char>(static_cast<uint8_t>(byte) | (static_cast<unsigned>(stored) << field.first_bit));
      }
    };
    if (source.column == nullptr) {
      for (size_t i = 0; i < count; ++i) put(i, source.fill);
      return;
    }
    std::visit(
        [&](const auto& values) {
          for (size_t i = 0; i < count; ++i) put(i, static_cast<double>(values[begin + i]));
        },
        source.column->values);
  });
}

}  // namespace curv
