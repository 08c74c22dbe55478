// Says which quantities the results of a call carry.
#pragma once

#include <cstdint>

#include "curvature/v1/curvature.pb.h"

namespace curvd {

// Quantities beside the status. DEFAULT: all of curvature that the contract knows, but for what follows from the rest.
class QuantitySet {
 public:
  static QuantitySet None() { return QuantitySet(0); }
  QuantitySet() = default;

  void Add(curvature::v1::Quantity quantity) { bits_ |= BitOf(quantity); }
  bool Has(curvature::v1::Quantity quantity) const { return (bits_ & BitOf(quantity)) != 0; }
  // Whether a quantity of curvature, or of normals, is among them.
  bool HasCurvature() const { return (bits_ & ~kNormalBits) != 0; }
  bool HasNormals() const { return (bits_ & kNormalBits) != 0; }
  // Whether one says how an estimate was chosen, or how sure it is.
  bool HasChoice() const { return (bits_ & kChoiceBits) != 0; }

 private:
  static_assert(curvature::v1::Quantity_ARRAYSIZE <= 64);
  static constexpr uint64_t BitOf(curvature::v1::Quantity quantity) { return uint64_t{1} << quantity; }
  static constexpr uint64_t kNormalBits =
      uint64_t{1} << curvature::v1::QUANTITY_NORMALS | uint64_t{1} << curvature::v1::QUANTITY_NORMAL_QUALITY;
  static constexpr uint64_t kChoiceBits = uint64_t{1} << curvature::v1::QUANTITY_STANDARD_ERRORS |
                                          uint64_t{1} << curvature::v1::QUANTITY_CHOSEN_NEIGHBOR_COUNT |
                                          uint64_t{1} << curvature::v1::QUANTITY_ESTIMATOR_WEIGHTS;
  static constexpr uint64_t kDerivedBits = uint64_t{1} << curvature::v1::QUANTITY_SHAPE_INDEX |
                                           uint64_t{1} << curvature::v1::QUANTITY_CURVEDNESS |
                                           uint64_t{1} << curvature::v1::QUANTITY_NORMAL_CURVATURE;
  explicit QuantitySet(uint64_t bits) : bits_(bits) {}

  // The others come only where they are asked for.
  uint64_t bits_ = ~(kNormalBits | kDerivedBits | kChoiceBits);
};

}  // namespace curvd
