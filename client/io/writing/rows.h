// Writes the rows of a table, as bytes or as text.
#pragma once

#include <charconv>
#include <span>
#include <string>

#include "absl/status/status.h"
#include "client/io/byte_sink.h"
#include "client/io/point_table.h"

namespace curv {

// Appends a number in the shortest digits that read back as the same value, whatever the locale.
template <typename T>
void AppendNumber(T value, std::string& out) {
  char digits[32];
  const std::to_chars_result result = std::to_chars(digits, digits + sizeof(digits), value);
  out.append(digits, result.ptr);
}

// Appends the scalars of each row one after the other, little-endian, without padding. Errors are those of
// ByteSink::Append.
absl::Status AppendBinaryRows(const PointTable& table, ByteSink& file);
// The same of some columns, in their order. REQUIRES: they are as long as each other.
absl::Status AppendBinaryColumns(std::span<const Column* const> columns, ByteSink& file);

// Appends a line for each row, with `separator` between values, in the shortest digits that read back as the same
// value. With `status_words` the column `status` of type uint8 is a word, where its value has one. Errors are those of
// ByteSink::Append.
absl::Status AppendTextRows(const PointTable& table, char separator, bool status_words, ByteSink& file);
// The same of some columns, in their order. REQUIRES: they are as long as each other.
absl::Status AppendTextRows(std::span<const Column* const> columns, char separator, bool status_words, ByteSink& file);

// Appends a line for each row as WriteXyz does: with x, y and z before all other columns, if the table has them. Errors
// are those of ByteSink::Append.
absl::Status AppendXyzRows(const PointTable& table, ByteSink& file);

// Append the rows of a table as WritePcd and WriteAsciiPcd do, with packed colors. Errors are those of
// ByteSink::Append.
absl::Status AppendPcdRows(const PointTable& table, ByteSink& file);
absl::Status AppendAsciiPcdRows(const PointTable& table, ByteSink& file);

}  // namespace curv
