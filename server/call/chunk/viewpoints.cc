#include "server/call/chunk/viewpoints.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace curvd {

absl::Status Viewpoints::Append(const curvature::wire::Pieces& pieces, ScalarType type) {
  return AppendKept(pieces, type, [](const Vector& vector) { return vector; });
}

size_t Viewpoints::FiniteRun(size_t first, size_t most) const {
  const auto is_finite = [](const std::array<double, 3>& v) {
    return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
  };
  const auto begin = span().begin() + static_cast<ptrdiff_t>(first);
  const auto end = begin + static_cast<ptrdiff_t>(most);
  return static_cast<size_t>(std::find_if_not(begin, end, is_finite) - begin);
}

}  // namespace curvd
