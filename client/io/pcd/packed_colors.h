// Colors in PCD files: one field of 32 bits, 0xAARRGGBB, which PCL declares as a float of these bits.
#pragma once

#include <vector>

#include "client/io/pcd/pcd_header.h"
#include "client/io/point_table.h"

namespace curv {

// Returns whether the field holds packed colors: rgb or rgba, one value of 4 bytes.
bool IsPackedColor(const PcdField& field);

// Returns the columns red green blue of packed colors, with alpha after them if the column is called rgba. Doubles are
// floats as text has them: of the bits of colors or, where one is 1 or more, which no color is whose alpha is 0 or 255,
// the integers themselves. Returns none if a double is NaN, as text does not say which of the many NaN it is, or is no
// 32-bit integer where others are.
// REQUIRES: the column is of a field for which IsPackedColor holds, with doubles in place of the floats of text.
std::vector<Column> UnpackColors(const Column& packed);

// What the rows of a PCD file hold.
struct PcdFields {
  std::vector<PcdField> fields;
  // Their values, of the table or of `made`: in binary rows a packed color is its bytes, from blue to alpha.
  std::vector<const Column*> columns;
  std::vector<Column> made;
};

// Returns the fields of a table, which must outlive them. red green blue of bytes become rgb in the place of red, and
// with an alpha of bytes rgba, unless the table has columns of these names. PCL reads an rgb that is a float from
// binary files; in text it is an integer, as most opaque colors are NaN there.
PcdFields FieldsOf(const PointTable& table, bool is_text);

}  // namespace curv
