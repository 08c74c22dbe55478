// Moves values between the records of LAS points and the columns of a table.
#pragma once

#include <cstddef>
#include <vector>

#include "client/io/las/las_fields.h"
#include "client/io/point_table.h"

namespace curv {

// Collects one field of many records into a column: of the field's type; of uint8 for fields within a byte; of double
// for scaled ones. Integers of 64 bits become doubles where that is exact for all of them, and otherwise two columns of
// uint32, NAME_low and NAME_high.
class LasColumnReader {
 public:
  explicit LasColumnReader(const LasField& field);

  // Makes room for so many records.
  void Reserve(size_t count);
  // Appends the field of `count` records, the first of which starts at `records`, `stride` bytes apart.
  // REQUIRES: each holds the field.
  void Append(const char* records, size_t count, size_t stride);
  // Returns the column, or both of them. Called once.
  std::vector<Column> Finish();

 private:
  LasField field_;
  Column column_;
  std::vector<uint64_t> wide_;  // in place of the column, for integers of 64 bits
};

// Where a field's values come from.
struct LasSource {
  const Column* column = nullptr;  // none: `fill` is the value of every point
  const Column* high = nullptr;    // with it, the column holds the low 32 bits of the values
  double factor = 1.0;             // applied to the column's values
  double fill = 0.0;
};

// Returns whether every value of the column comes back from the field as it is, NaN included.
bool Fits(const LasField& field, const Column& column);

// Writes the field of `count` records from rows `begin` on. Fields within a byte are or-ed in. REQUIRES: each record
// holds the field; what the source has Fits.
void Store(const LasField& field, const LasSource& source, size_t begin, size_t count, size_t stride, char* records);

}  // namespace curv
