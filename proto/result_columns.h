// The arrays of a ResultChunk as the contract declares them, for code that knows none by name.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "curvature/v1/curvature.pb.h"

namespace curvature::wire {

struct ResultColumn {
  std::string name;        // the field's: "mean_curvature"
  int field;               // its number
  v1::Quantity quantity;   // that asks for it; QUANTITY_UNSPECIFIED: it is always there
  v1::ColumnType type;     // never COLUMN_TYPE_UNSPECIFIED
  size_t width;            // scalars a point
  size_t bytes_per_point;  // of all its scalars
  bool on_request;         // whether it is none of those that come without being asked for
};

// Every column, in the order of their field numbers. Made once, from the option `column` of each field. Thread-safe.
const std::vector<ResultColumn>& ResultColumns();

// Every quantity but QUANTITY_UNSPECIFIED, in the order of their numbers. Thread-safe.
const std::vector<v1::Quantity>& Quantities();

// The name of a quantity as users write it: QUANTITY_MEAN_CURVATURE is "mean_curvature". Empty for an unknown one.
std::string QuantityName(v1::Quantity quantity);

// The quantity of that name; nothing for an unknown one and for "unspecified".
std::optional<v1::Quantity> QuantityOf(std::string_view name);

}  // namespace curvature::wire
