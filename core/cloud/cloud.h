// An oriented point cloud, collected from packed arrays and kept as floats relative to a local origin.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "core/base/page_array.h"
#include "core/cloud/lattice.h"
#include "core/cloud/point_record.h"
#include "core/cloud/point_set.h"

namespace curvd {

// Scalar type of packed input.
enum class ScalarType : uint8_t { kFloat32, kFloat64 };
constexpr size_t ScalarBytes(ScalarType type) { return type == ScalarType::kFloat32 ? 4 : 8; }

enum class InvalidPointPolicy : uint8_t {
  kReject,  // Append fails at the first such point
  kSkip,    // the point is nobody's neighbor and ends with PointStatus::kInvalidInput
};

enum class NormalsInput : uint8_t {
  kGiven,   // a normal comes with each point
  kAbsent,  // none comes, and no memory is taken for any
};

// Bytes that a cloud holds for each of its points: a record and a normal.
inline constexpr size_t kCloudBytesPerPoint = sizeof(PointRecord) + 3 * sizeof(float);

// float32 positions are stored as they are; float64 positions relative to a local origin: the component-wise median of
// the first 1024 valid positions (of all, if fewer), so that one outlier cannot spoil it. The origin depends on the
// points alone, never on the chunking. Stored coordinates then differ from the exact ones by at most 2^-24 of the
// distance from the origin. Both go to a lattice instead where one is set.
//
// A point is invalid if a coordinate of its position or normal is not finite (or its position not finite in float32
// after the shift), or if its normal is zero. Normals of any other length are normalized.
//
// Not thread-safe; const methods are.
class Cloud {
 public:
  static constexpr size_t kBlockPoints = 65'536;

  explicit Cloud(ScalarType scalar_type = ScalarType::kFloat32, InvalidPointPolicy policy = InvalidPointPolicy::kReject,
                 NormalsInput normals = NormalsInput::kGiven);
  Cloud(Cloud&&) noexcept = default;
  Cloud& operator=(Cloud&&) noexcept = default;

  // Says how many points will come, so that one array of their size is made for them. REQUIRES: called before Append.
  void Expect(size_t points) { expected_ = points; }

  // Places positions on a lattice. REQUIRES: called before Append; lattice.Validate() is OK.
  void PlaceOn(const Lattice& lattice) {
    lattice_ = lattice;
    origin_ = lattice.origin;
  }

  // Appends points from packed little-endian arrays, 3 scalars a point in each. Those that
  // Describe did not tell of get a result, and have as id their index in the cloud. Throws nothing; KindOf
  // (core/base/error.h) tells errors apart:
  // - kInvalid: lengths are not multiples of a point, or differ, more points come than were expected, or (kReject) a
  //   point is invalid; the message names the field, the point's index in the cloud and the value.
  // - kOutOfMemory: the system gave no memory.
  // An error leaves the cloud with the points before the one at which it came, size() of them. After kOutOfMemory, the
  // points from there on may be given again. Doubles that are too far from the other points may be noticed later, by
  // a call that brings others, or by Finish; each call after that fails alike.
  // A cloud of NormalsInput::kAbsent takes empty `normals` only.
  absl::Status Append(std::string_view positions, std::string_view normals);

  // Says what the next `count` points are, beyond those that were described before: their ids in a larger cloud, and
  // which of them get a result; where an array is empty, they have as id their index in this cloud, and all do. Throws
  // nothing. Errors: kOutOfMemory; kInvalid: the cloud would have too many points.
  // REQUIRES: an array holds `count` entries, or none.
  absl::Status Describe(size_t count, std::span<const uint64_t> ids, std::span<const PointRole> roles);

  // Describe and Append. Further errors of kind kInvalid: there are not as many ids, or roles, as points.
  absl::Status AppendPart(std::string_view positions, std::string_view normals, std::span<const uint64_t> ids,
                          std::span<const PointRole> roles = {});

  // Ends the cloud: no Append may follow. Errors as those of Append that name no lengths; throws nothing.
  // REQUIRES: called once before the cloud is estimated, or again after kOutOfMemory.
  absl::Status Finish();

  // Gives the points their ranks, which are then the ids of their records. Errors: kRepeatedId, kOutOfMemory.
  // Throws nothing. REQUIRES: Finish was called; called once, before all that follows from ranks.
  absl::Status Rank();

  // Points appended, invalid ones included.
  size_t size() const { return size_; }
  size_t invalid_count() const { return invalid_count_; }
  // Invalid points that get a result, which says so. Complete once Finish was called, as is invalid_count.
  size_t invalid_query_count() const { return invalid_query_count_; }
  // Of the positions as they were given.
  ScalarType scalar_type() const { return scalar_type_; }
  bool has_normals() const { return normals_ == NormalsInput::kGiven; }
  InvalidPointPolicy policy() const { return policy_; }
  // Roles, ids and slots of the points.
  const PointSet& point_set() const { return point_set_; }
  // Gives them away; the cloud then knows of none.
  PointSet TakePointSet() { return std::exchange(point_set_, PointSet()); }
  // Points whose normal differed from unit length by more than 1 %.
  size_t rescaled_count() const { return rescaled_count_; }
  // What was subtracted from every position that was given: zeros for float32 without a lattice.
  // REQUIRES: Finish was called.
  std::array<double, 3> origin() const { return origin_.value_or(std::array<double, 3>{}); }
  // Of the lattice that positions are on; 0: on none.
  double lattice_spacing() const { return lattice_.has_value() ? lattice_->spacing : 0.0; }
  // Bytes held.
  size_t bytes() const;

  // The position of point i in input order, relative to the local origin, with id i, or its rank once it
  // has one; NaN if the point is invalid.
  // REQUIRES: Finish was called, TakeRecords was not, i < size().
  const PointRecord& record(size_t i) const { return blocks_[i / kBlockPoints].records[i % kBlockPoints]; }
  std::array<float, 3> position(size_t i) const {
    const PointRecord& point = record(i);
    return {point.position[0], point.position[1], point.position[2]};
  }
  // The unit normal of point i; NaN if the point is invalid. REQUIRES: has_normals(), Finish was called, i < size().
  const std::array<float, 3>& normal(size_t i) const { return blocks_[i / kBlockPoints].normals[i % kBlockPoints]; }

  // Gives away the records of all points, in one array of whole leaves, if they lie so (the cloud came as expected) and
  // all are valid; else nothing, and the cloud keeps them. REQUIRES: Finish was called.
  PageArray<PointRecord> TakeRecords();

 private:
  struct Slab {
    PageArray<PointRecord> records;
    PageArray<std::array<float, 3>> normals;
  };
  // kBlockPoints points of a slab.
  struct Block {
    PointRecord* records;
    std::array<float, 3>* normals;
  };
  struct ExactPoint {
    std::array<double, 3> position;
    std::array<float, 3> normal;
  };

  static absl::Status CheckSize(size_t size);
  absl::Status CheckLengths(std::string_view positions, std::string_view normals) const;
  // Appends points that point_set_ has already; after an error, takes those out again that were not appended.
  absl::Status AppendPoints(std::string_view positions, std::string_view normals);
  absl::Status AppendBareFloats(const char* positions, size_t count);
  absl::Status AppendFloats(const char* positions, const char* normals, size_t count);
  absl::Status AppendDoubles(const char* positions, const char* normals, size_t count);
  template <typename Scalar>
  absl::Status AppendOnLattice(const char* positions, const char* normals, size_t count);
  template <typename Scalar>
  bool Take(std::array<Scalar, 3>& position, const std::array<Scalar, 3>& normal, std::array<float, 3>& unit);
  void CountInvalid(size_t rank);
  template <typename Scalar>
  absl::Status RefusalOf(const std::array<Scalar, 3>& position, const std::array<Scalar, 3>& normal) const;
  // Makes sure that the last block has a free slot; if it cannot, the cloud is as it was.
  absl::Status MakeRoom();
  absl::Status AddSlab();
  // REQUIRES: MakeRoom returned OK since the last one.
  void Store(const std::array<float, 3>& position, const std::array<float, 3>& normal);
  // Stores the points of pending_ up to the first that cannot be.
  absl::Status StorePending();
  std::array<double, 3> OriginOfPending() const;

  ScalarType scalar_type_;
  InvalidPointPolicy policy_;
  NormalsInput normals_;
  PointSet point_set_;
  size_t size_ = 0;
  size_t stored_ = 0;
  size_t invalid_count_ = 0;
  size_t invalid_query_count_ = 0;
  size_t rescaled_count_ = 0;
  std::optional<Lattice> lattice_;
  std::optional<std::array<double, 3>> origin_;  // set once float64 input can be shifted
  std::vector<ExactPoint> pending_;              // float64 points that wait for the origin
  std::vector<Slab> slabs_;                      // hold the blocks
  std::vector<Block> blocks_;
  Block next_block_{};      // in the last slab
  size_t free_blocks_ = 0;  // from next_block_ on
  size_t expected_ = 0;     // 0: nobody knows
};

}  // namespace curvd
