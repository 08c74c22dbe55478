// Names the columns of files that name none.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "client/io/point_table.h"

namespace curv {

// What columns 4 to 6 are if no point has a vector there that is longer than 0.
enum class NoVectors { kAreNormals, kAreNone };

// Names columns by their places: x y z, then column4 and so on. Six columns whose last three are integers from 0 to
// 255, some above 1, hold colors: they become red green blue, of bytes. Otherwise columns 4 to 6 of six or more are nx
// ny nz if they hold vectors of length 1, to a tenth; a note that ends with `remedy` says where they do not.
void NameByPlace(NoVectors no_vectors, std::string_view remedy, std::vector<Column>& columns,
                 std::vector<std::string>& notes);

}  // namespace curv
