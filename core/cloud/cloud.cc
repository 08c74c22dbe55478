#include "core/cloud/cloud.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/base/error.h"
#include "core/base/median.h"
#include "core/base/number_text.h"
#include "core/base/out_of_memory.h"
#include "core/cloud/invalid_point.h"
#include "core/cloud/unit_normals.h"

namespace curvd {
namespace {

static_assert(std::endian::native == std::endian::little, "packed input is little-endian and is copied as it is");

constexpr size_t kOriginSample = 1024;   // float64 points that decide the origin
constexpr double kUnitTolerance = 0.01;  // a normal within 1 % of unit length does not count as rescaled
constexpr size_t kTripleBytes = 3 * sizeof(float);
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

template <typename Scalar>
using Triple = std::array<Scalar, 3>;

template <typename Scalar>
Triple<Scalar> LoadTriple(const char* packed, size_t i) {
  Triple<Scalar> triple;
  std::memcpy(triple.data(), packed + i * sizeof(triple), sizeof(triple));
  return triple;
}

template <typename Scalar>
bool AllFinite(const Triple<Scalar>& v) {
  // One multiply turns any infinity into NaN, and a NaN survives the sum.
  return v[0] * Scalar{0} + v[1] * Scalar{0} + v[2] * Scalar{0} == Scalar{0};
}

template <typename Scalar>
double Length(const Triple<Scalar>& v) {
  if constexpr (std::is_same_v<Scalar, float>) {
    const double x = v[0], y = v[1], z = v[2];
    return std::sqrt(x * x + y * y + z * z);  // no float's square leaves the doubles
  } else {
    return std::hypot(v[0], v[1], v[2]);
  }
}

// Length of a usable normal, else 0.
template <typename Scalar>
double UsableLength(const Triple<Scalar>& normal) {
  if (!AllFinite(normal)) return 0.0;
  return std::min(Length(normal), std::numeric_limits<double>::max());
}

// Lengths whose inverse, and whose own digits, doubles hold in full.
constexpr double kShortestLength = 1e-290;
constexpr double kLongestLength = 1e290;

// REQUIRES: length is UsableLength(v), not 0.
template <typename Scalar>
Triple<float> Normalized(const Triple<Scalar>& v, double length) {
  if constexpr (std::is_same_v<Scalar, double>) {
    if (length < kShortestLength || length > kLongestLength) {
      const int exponent = std::ilogb(std::max({std::abs(v[0]), std::abs(v[1]), std::abs(v[2])}));
      const Triple<double> scaled = {std::scalbn(v[0], -exponent), std::scalbn(v[1], -exponent),
                                     std::scalbn(v[2], -exponent)};
      return Normalized(scaled, Length(scaled));
    }
  }
  const double per_length = 1.0 / length;
  return {static_cast<float>(v[0] * per_length), static_cast<float>(v[1] * per_length),
          static_cast<float>(v[2] * per_length)};
}

PointRecord MakeRecord(const Triple<float>& position, size_t id) {
  return {{position[0], position[1], position[2]}, static_cast<int32_t>(id)};
}

}  // namespace

Cloud::Cloud(ScalarType scalar_type, InvalidPointPolicy policy, NormalsInput normals)
    : scalar_type_(scalar_type), policy_(policy), normals_(normals) {
  PrepareOutOfMemoryError();
  if (scalar_type == ScalarType::kFloat32) origin_ = {0.0, 0.0, 0.0};
}

size_t Cloud::bytes() const {
  size_t points = blocks_.size() * kBlockPoints;
  if (expected_ > 0) points = std::min(points, expected_);
  const bool has_records = !slabs_.empty() && slabs_.front().records.size() > 0;
  const size_t point_bytes = (has_records ? sizeof(PointRecord) : 0) + (has_normals() ? sizeof(Triple<float>) : 0);
  return points * point_bytes + pending_.capacity() * sizeof(ExactPoint) + point_set_.bytes();
}

absl::Status Cloud::Append(std::string_view positions, std::string_view normals) {
  return CatchBadAlloc([&] {
    if (absl::Status status = CheckLengths(positions, normals); !status.ok()) return status;
    const size_t size = size_ + positions.size() / (3 * ScalarBytes(scalar_type_));
    if (size > point_set_.size()) point_set_.AddQueries(size - point_set_.size());
    return AppendPoints(positions, normals);
  });
}

absl::Status Cloud::Describe(size_t count, std::span<const uint64_t> ids, std::span<const PointRole> roles) {
  if (absl::Status status = CheckSize(point_set_.size() + count); !status.ok()) return status;
  return CatchBadAlloc([&] {
    point_set_.AddPart(count, ids, roles);
    return absl::OkStatus();
  });
}

absl::Status Cloud::AppendPart(std::string_view positions, std::string_view normals, std::span<const uint64_t> ids,
                               std::span<const PointRole> roles) {
  if (absl::Status status = CheckLengths(positions, normals); !status.ok()) return status;
  const size_t count = positions.size() / (3 * ScalarBytes(scalar_type_));
  if (ids.size() != count || (!roles.empty() && roles.size() != count)) {
    return MakeCoreError(ErrorKind::kInvalid, absl::StrCat("ids has ", ids.size(), " entries and roles ", roles.size(),
                                                           "; positions has ", count, " points"));
  }
  if (absl::Status status = Describe(count, ids, roles); !status.ok()) return status;
  return Append(positions, normals);
}

absl::Status Cloud::CheckSize(size_t size) {
  if (size <= std::numeric_limits<int32_t>::max()) return absl::OkStatus();
  return MakeCoreError(ErrorKind::kInvalid,
                       absl::StrCat("cloud has more than ", std::numeric_limits<int32_t>::max(), " points"));
}

absl::Status Cloud::CheckLengths(std::string_view positions, std::string_view normals) const {
  const size_t point_bytes = 3 * ScalarBytes(scalar_type_);
  if (positions.size() % point_bytes != 0) {
    return MakeCoreError(ErrorKind::kInvalid,
                         absl::StrCat("positions has ", positions.size(), " bytes; it must be a multiple of ",
                                      point_bytes, " (3 scalars of ", ScalarBytes(scalar_type_), " bytes a point)"));
  }
  if (!has_normals() && !normals.empty()) {
    return MakeCoreError(ErrorKind::kInvalid,
                         absl::StrCat("normals has ", normals.size(), " bytes; the cloud has none"));
  }
  if (has_normals() && normals.size() != positions.size()) {
    return MakeCoreError(ErrorKind::kInvalid,
                         absl::StrCat("normals has ", normals.size(), " bytes and positions has ", positions.size(),
                                      "; both must hold the same number of points"));
  }
  const size_t count = positions.size() / point_bytes;
  if (absl::Status status = CheckSize(size_ + count); !status.ok()) return status;
  if (expected_ > 0 && size_ + count > expected_) {
    return MakeCoreError(ErrorKind::kInvalid, absl::StrCat("positions brings the cloud to ", size_ + count, " points; ",
                                                           expected_, " were expected"));
  }
  return absl::OkStatus();
}

absl::Status Cloud::AppendPoints(std::string_view positions, std::string_view normals) {
  const size_t count = positions.size() / (3 * ScalarBytes(scalar_type_));
  absl::Status status = CatchBadAlloc([&] {
    if (lattice_.has_value()) {
      return scalar_type_ == ScalarType::kFloat64 ? AppendOnLattice<double>(positions.data(), normals.data(), count)
                                                  : AppendOnLattice<float>(positions.data(), normals.data(), count);
    }
    if (scalar_type_ == ScalarType::kFloat64) return AppendDoubles(positions.data(), normals.data(), count);
    return has_normals() ? AppendFloats(positions.data(), normals.data(), count)
                         : AppendBareFloats(positions.data(), count);
  });
  if (!status.ok()) point_set_.Truncate(size_);
  return status;
}

void Cloud::CountInvalid(size_t rank) {
  ++invalid_count_;
  invalid_query_count_ += point_set_.is_query(static_cast<int32_t>(rank)) ? 1 : 0;
}

// Takes a point into the counts, with its normal brought to unit length, and NaN for an invalid one. Returns false,
// and takes nothing, if the point is refused.
template <typename Scalar>
bool Cloud::Take(Triple<Scalar>& position, const Triple<Scalar>& normal, Triple<float>& unit) {
  const double length = AllFinite(position) ? UsableLength(normal) : 0.0;
  if (length > 0.0) {
    unit = Normalized(normal, length);
    rescaled_count_ += std::abs(length - 1.0) > kUnitTolerance ? 1 : 0;
  } else {
    if (policy_ == InvalidPointPolicy::kReject) return false;
    constexpr auto kNotANumber = std::numeric_limits<Scalar>::quiet_NaN();
    position = {kNotANumber, kNotANumber, kNotANumber};
    unit = {kNaN, kNaN, kNaN};
    CountInvalid(size_);
  }
  ++size_;
  return true;
}

template <typename Scalar>
absl::Status Cloud::RefusalOf(const Triple<Scalar>& position, const Triple<Scalar>& normal) const {
  return AllFinite(position) ? InvalidPoint("normal", size_, VectorText(normal), "finite and not zero")
                             : InvalidPoint("position", size_, VectorText(position), "finite");
}

absl::Status Cloud::AppendFloats(const char* positions, const char* normals, size_t count) {
  for (size_t first = 0; first < count;) {
    if (absl::Status status = MakeRoom(); !status.ok()) return status;
    const size_t offset = stored_ % kBlockPoints;
    const size_t run = std::min({count - first, kBlockPoints - offset, UnitNormals::kMaxPoints});
    UnitNormals unit;
    MakeUnitNormals(positions + first * kTripleBytes, normals + first * kTripleBytes, run, kUnitTolerance, unit);
    const bool all_usable = static_cast<size_t>(std::popcount(unit.usable)) == run;
    const Block out = {blocks_.back().records + offset, blocks_.back().normals + offset};
    if (all_usable) {
      for (size_t i = 0; i < run; ++i) {
        out.records[i] = MakeRecord(LoadTriple<float>(positions, first + i), stored_ + i);
      }
      std::memcpy(out.normals, unit.normals, run * kTripleBytes);
      rescaled_count_ += static_cast<size_t>(std::popcount(unit.rescaled));
      size_ += run;
      stored_ += run;
    } else {
      for (size_t i = 0; i < run; ++i) {
        Triple<float> position = LoadTriple<float>(positions, first + i);
        const Triple<float> normal = LoadTriple<float>(normals, first + i);
        if (!Take(position, normal, out.normals[i])) return RefusalOf(position, normal);
        out.records[i] = MakeRecord(position, stored_);
        ++stored_;
      }
    }
    first += run;
  }
  return absl::OkStatus();
}

absl::Status Cloud::AppendBareFloats(const char* positions, size_t count) {
  constexpr Triple<float> kAnyNormal = {0.0f, 0.0f, 1.0f};
  for (size_t i = 0; i < count; ++i) {
    if (absl::Status status = MakeRoom(); !status.ok()) return status;
    Triple<float> position = LoadTriple<float>(positions, i), unit;
    if (!Take(position, kAnyNormal, unit)) return RefusalOf(position, kAnyNormal);
    Store(position, unit);
  }
  return absl::OkStatus();
}

absl::Status Cloud::AppendDoubles(const char* positions, const char* normals, size_t count) {
  for (size_t i = 0; i < count; ++i) {
    ExactPoint point{LoadTriple<double>(positions, i), {}};
    const Triple<double> normal = has_normals() ? LoadTriple<double>(normals, i) : Triple<double>{0.0, 0.0, 1.0};
    if (pending_.size() == pending_.capacity()) pending_.reserve(std::max<size_t>(1, 2 * pending_.size()));
    if (!Take(point.position, normal, point.normal)) return RefusalOf(point.position, normal);
    pending_.push_back(point);  // has room
    if (!origin_.has_value() && pending_.size() < kOriginSample) continue;
    if (absl::Status status = StorePending(); !status.ok()) return status;
  }
  return absl::OkStatus();
}

template <typename Scalar>
absl::Status Cloud::AppendOnLattice(const char* positions, const char* normals, size_t count) {
  for (size_t i = 0; i < count; ++i) {
    if (absl::Status status = MakeRoom(); !status.ok()) return status;
    const Triple<Scalar> given = LoadTriple<Scalar>(positions, i);
    const Triple<Scalar> normal = has_normals() ? LoadTriple<Scalar>(normals, i) : Triple<Scalar>{0, 0, 1};
    const Triple<double> exact = {given[0], given[1], given[2]};
    std::optional<Triple<float>> placed;
    if (AllFinite(given)) placed = lattice_->Place(exact);
    if (AllFinite(given) && !placed.has_value() && policy_ == InvalidPointPolicy::kReject) {
      return InvalidPoint("position", size_, VectorText(given),
                          absl::StrCat("within 2^23 times lattice.spacing, ", NumberText(lattice_->spacing),
                                       ", of lattice.origin, ", VectorText(lattice_->origin)),
                          "choose another origin or a larger spacing");
    }
    Triple<float> position = placed.value_or(Triple<float>{kNaN, kNaN, kNaN}), unit;
    if (placed.has_value()) {
      Triple<Scalar> usable = given;
      if (!Take(usable, normal, unit)) return RefusalOf(given, normal);
      if (!AllFinite(usable)) position = {kNaN, kNaN, kNaN};
    } else if (Triple<Scalar> unusable = {kNaN, kNaN, kNaN}; !Take(unusable, normal, unit)) {
      return RefusalOf(given, normal);
    }
    Store(position, unit);
  }
  return absl::OkStatus();
}

absl::Status Cloud::MakeRoom() {
  if (stored_ < blocks_.size() * kBlockPoints) return absl::OkStatus();
  if (free_blocks_ == 0) {
    if (absl::Status status = AddSlab(); !status.ok()) return status;
  }
  blocks_.push_back(next_block_);
  next_block_ = {next_block_.records + kBlockPoints, has_normals() ? next_block_.normals + kBlockPoints : nullptr};
  --free_blocks_;
  return absl::OkStatus();
}

absl::Status Cloud::AddSlab() {
  // If nobody knows how many points will come, a small cloud is content with one block; a large one takes as many at a
  // time as get huge pages.
  constexpr size_t kSlabBlocks = 8;
  const size_t blocks = expected_ > 0     ? (expected_ + kBlockPoints - 1) / kBlockPoints
                        : blocks_.empty() ? 1
                                          : kSlabBlocks;
  const PageUse use = expected_ > 0 ? PageUse::kWhole : PageUse::kSparse;
  const size_t points = expected_ > 0 ? expected_ : blocks * kBlockPoints;
  auto records = PageArray<PointRecord>::Create((points + kLeafRecords - 1) / kLeafRecords * kLeafRecords, use);
  if (!records.ok()) return records.status();
  auto normals = PageArray<Triple<float>>::Create(has_normals() ? points : 0, use);
  if (!normals.ok()) return normals.status();
  const Block first = {records->data(), normals->data()};
  slabs_.push_back({*std::move(records), *std::move(normals)});
  next_block_ = first;
  free_blocks_ = blocks;
  return absl::OkStatus();
}

void Cloud::Store(const Triple<float>& position, const Triple<float>& normal) {
  blocks_.back().records[stored_ % kBlockPoints] = MakeRecord(position, stored_);
  if (has_normals()) blocks_.back().normals[stored_ % kBlockPoints] = normal;
  ++stored_;
}

std::array<double, 3> Cloud::OriginOfPending() const {
  std::array<double, 3> origin = {0.0, 0.0, 0.0};
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const ExactPoint& point : pending_) {
      if (!std::isnan(point.position[0])) values.push_back(point.position[axis]);
    }
    if (!values.empty()) origin[axis] = Median(values);
  }
  return origin;
}

absl::Status Cloud::StorePending() {
  if (!origin_.has_value()) origin_ = OriginOfPending();
  absl::Status status;
  size_t stored = 0;
  for (; stored < pending_.size(); ++stored) {
    if (status = MakeRoom(); !status.ok()) break;
    const ExactPoint& point = pending_[stored];
    Triple<float> position, normal = point.normal;
    for (int axis = 0; axis < 3; ++axis) {
      position[axis] = static_cast<float>(point.position[axis] - (*origin_)[axis]);
    }
    if (!std::isnan(point.position[0]) && !AllFinite(position)) {
      if (policy_ == InvalidPointPolicy::kReject) {
        status = InvalidPoint("position", stored_, VectorText(point.position), "within 3e38 of the other points");
        break;
      }
      CountInvalid(stored_);
      position = normal = {kNaN, kNaN, kNaN};
    }
    Store(position, normal);
  }
  pending_.erase(pending_.begin(), pending_.begin() + static_cast<ptrdiff_t>(stored));
  return status;
}

absl::Status Cloud::Finish() {
  absl::Status status = CatchBadAlloc([this] { return StorePending(); });
  if (status.ok()) pending_ = {};
  return status;
}

absl::Status Cloud::Rank() {
  return CatchBadAlloc([&] {
    if (const std::optional<PointSet::Twins> twins = point_set_.Rank()) {
      return MakeCoreError(ErrorKind::kRepeatedId,
                           absl::StrCat("ids of points ", twins->first, " and ", twins->second, " are both ", twins->id,
                                        "; every point needs an id of its own"),
                           {"ids", absl::StrCat(twins->id), absl::StrCat("other than that of point ", twins->first),
                            absl::StrCat(twins->second)});
    }
    if (!point_set_.is_reordered()) return absl::OkStatus();
    for (size_t rank = 0; rank < size_; ++rank) {
      const size_t place = point_set_.place_of(static_cast<int32_t>(rank));
      blocks_[place / kBlockPoints].records[place % kBlockPoints].id = static_cast<int32_t>(rank);
    }
    return absl::OkStatus();
  });
}

PageArray<PointRecord> Cloud::TakeRecords() {
  if (slabs_.size() != 1 || invalid_count_ > 0) return {};
  PageArray<PointRecord>& records = slabs_.front().records;
  const bool fits = records.size() == (size_ + kLeafRecords - 1) / kLeafRecords * kLeafRecords;
  return fits ? std::exchange(records, {}) : PageArray<PointRecord>();
}

}  // namespace curvd
