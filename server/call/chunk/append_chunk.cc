#include "server/call/chunk/append_chunk.h"

#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <string>
#include <string_view>

#include "absl/strings/str_cat.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/cloud/invalid_point.h"
#include "curvature/v1/curvature.pb.h"
#include "server/call/chunk/piece_reader.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;
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

// In as many digits as the caller sent.
std::string TextOf(const std::array<double, 3>& v, ScalarType type) {
  if (type == ScalarType::kFloat64) return VectorText(v);
  return VectorText(std::array{static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])});
}

absl::Status TakeRoles(PieceReader& reader, size_t first_point, std::span<PointRole> roles) {
  for (size_t i = 0; i < roles.size(); ++i) {
    const auto byte = static_cast<unsigned char>(reader.Take(1).front());
    if (byte > v1::POINT_ROLE_HALO) {
      constexpr char kLimit[] = "1 (query) or 2 (halo)";
      const std::string point = absl::StrCat(first_point + i), value = absl::StrCat(static_cast<int>(byte));
      return MakeCoreError(ErrorKind::kInvalid,
                           absl::StrCat("role of point ", point, " is ", value, "; it must be ", kLimit),
                           {"roles", value, kLimit, point});
    }
    roles[i] = byte == v1::POINT_ROLE_HALO ? PointRole::kHalo : PointRole::kQuery;
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status DescribePieces(const Pieces& ids, const Pieces& roles, size_t count, Cloud& cloud) {
  constexpr size_t kMost = 512;
  const bool has_ids = curvature::wire::SizeOf(ids) > 0, has_roles = curvature::wire::SizeOf(roles) > 0;
  PieceReader id_reader(ids), role_reader(roles);
  std::array<uint64_t, kMost> some_ids;
  std::array<PointRole, kMost> some_roles;
  PieceReader::PointBytes room;
  for (size_t first = 0; first < count; first += kMost) {
    const size_t size = std::min(kMost, count - first);
    for (size_t i = 0; has_ids && i < size; ++i) {
      id_reader.TakePoint(sizeof(uint64_t), room).copy(reinterpret_cast<char*>(&some_ids[i]), sizeof(uint64_t));
    }
    const std::span<PointRole> taken = std::span(some_roles).first(has_roles ? size : 0);
    if (absl::Status status = TakeRoles(role_reader, cloud.size() + first, taken); !status.ok()) return status;
    absl::Status status = cloud.Describe(size, std::span(some_ids).first(has_ids ? size : 0), taken);
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

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
        return InvalidPoint("viewpoint", cloud.size(), TextOf(v, type), "finite");
      });
}

}  // namespace curvd
