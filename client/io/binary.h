// Reads rows of packed scalars from binary files.
#pragma once

#include <bit>
#include <cstddef>
#include <span>
#include <string_view>

#include "client/io/point_table.h"

namespace curv {

// Little-endian files hold scalars as this machine does.
static_assert(std::endian::native == std::endian::little);

// The kind of column that holds such scalars: integers of 8 bytes become doubles (AppendLongIntegers).
ScalarKind KindOfScalar(size_t bytes, bool is_float, bool is_signed);

// Says where in a row a column's scalar lies.
struct RowField {
  size_t offset;   // bytes from the start of the row
  Column* column;  // not null
};

// Appends `count` rows of `row_bytes` bytes to the columns; `swap` for big-endian scalars.
// REQUIRES: rows holds at least count * row_bytes bytes; each field lies within its row.
void AppendRows(std::string_view rows, size_t count, size_t row_bytes, std::span<const RowField> fields, bool swap);

// Appends `count` scalars that lie `stride` bytes apart. REQUIRES: first points at that many.
void AppendStrided(const char* first, size_t count, size_t stride, bool swap, Column& column);

}  // namespace curv
