// Integers of more bits than a double holds, which tables have no type for.
#pragma once

#include <cstddef>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "client/io/point_table.h"

namespace curv {

// Appends `count` integers of 64 bits that lie `stride` bytes apart to a column of doubles; `swap` for big-endian ones.
// Returns whether all of them are doubles. REQUIRES: first points at that many.
bool AppendLongIntegers(const char* first, size_t count, size_t stride, bool swap, bool is_signed, Column& column);

// Returns whether text is an integer of which `value`, the double nearest to it, is another one.
bool IsRounded(std::string_view text, double value);

// Appends a note for each column of that name that lost digits.
void NoteRounded(const std::set<std::string>& columns, std::vector<std::string>& notes);

}  // namespace curv
