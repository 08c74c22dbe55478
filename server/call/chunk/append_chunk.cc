#include "server/call/chunk/append_chunk.h"

#include <algorithm>
#include <limits>
#include <string_view>

#include "absl/strings/str_format.h"
#include "core/base/error.h"
#include "server/call/chunk/piece_reader.h"

namespace curvd {
namespace {

using curvature::wire::Pieces;

// Appends points, those that lie together at once. `run_of(most)` says how many of the next `most` points may be
// appended as they are; where it is 0, `refuse(bytes)` makes the next one unusable, or says why it cannot be.
template <typename RunOf, typename Refuse>
absl::Status AppendRuns(const Pieces& positions, const Pieces& normals, ScalarType type, Cloud& cloud, RunOf run_of,
                        Refuse refuse) {
  const size_t point_bytes = 3 * ScalarBytes(type);
  PieceReader position(positions), normal(normals);
  PieceReader::PointBytes position_bytes, normal_bytes;
  while (position.together() > 0) {
    const size_t together =
        cloud.has_normals() ? std::min(position.together(), normal.together()) : position.together();
    const size_t usable = run_of(std::max<size_t>(together / point_bytes, 1));
    const size_t whole = std::min(together / point_bytes, usable) * point_bytes;
    absl::Status status;
    if (whole > 0) {
      status = cloud.Append(position.Take(whole), cloud.has_normals() ? normal.Take(whole) : std::string_view());
    } else {
      const std::string_view point = position.TakePoint(point_bytes, position_bytes);
      if (usable == 0) status = refuse(position_bytes);
      const std::string_view point_normal =
          cloud.has_normals() ? normal.TakePoint(point_bytes, normal_bytes) : std::string_view();
      if (status.ok()) status = cloud.Append(point, point_normal);
    }
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

// Makes a position unusable.
void MakeNotANumber(ScalarType type, PieceReader::PointBytes& position) {
  constexpr float kFloat = std::numeric_limits<float>::quiet_NaN();
  constexpr double kDouble = std::numeric_limits<double>::quiet_NaN();
  if (type == ScalarType::kFloat32) {
    std::copy_n(reinterpret_cast<const char*>(&kFloat), sizeof(kFloat), position.data());
  } else {
    std::copy_n(reinterpret_cast<const char*>(&kDouble), sizeof(kDouble), position.data());
  }
}

}  // namespace

absl::Status AppendPieces(const Pieces& positions, const Pieces& normals, ScalarType type, Cloud& cloud) {
  return AppendRuns(
      positions, normals, type, cloud, [](size_t most) { return most; },
      [](PieceReader::PointBytes&) { return absl::OkStatus(); });
}

absl::Status AppendSeenPieces(const Pieces& positions, const Pieces& normals, ScalarType type,
                              const Viewpoints& viewpoints, Cloud& cloud) {
  return AppendRuns(
      positions, normals, type, cloud, [&](size_t most) { return viewpoints.FiniteRun(cloud.size(), most); },
      [&](PieceReader::PointBytes& position) {
        if (cloud.policy() == InvalidPointPolicy::kSkip) {
          MakeNotANumber(type, position);
          return absl::OkStatus();
        }
        const std::array<double, 3>& v = viewpoints[cloud.size()];
        return MakeCoreError(
            ErrorKind::kInvalid,
            absl::StrFormat("viewpoint of point %u is (%g, %g, %g); it must be finite; mend the point, "
                            "or set invalid_point_policy to SKIP",
                            cloud.size(), v[0], v[1], v[2]));
      });
}

}  // namespace curvd
