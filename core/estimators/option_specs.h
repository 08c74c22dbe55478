// The table of what callers may set of an estimate, besides the strategy and the neighborhood.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "core/estimators/options.h"

namespace curvd {

// One option: a number or a flag. Its default is what a new EstimatorOptions has.
struct OptionSpec {
  using Member = std::variant<uint32_t EstimatorOptions::*, uint64_t EstimatorOptions::*, double EstimatorOptions::*,
                              bool EstimatorOptions::*>;

  // Of the field, here and in curvature.v1.EstimatorOptions.
  std::string_view name;
  Member member;
  // The values that it may have, both included. Not looked at for flags and 64-bit numbers, which may have any.
  double least;
  double most;
  // What it is, in one line.
  std::string_view doc;

  // Whether the option has a value in its range.
  bool InRange(const EstimatorOptions& options) const;
  // The value as text, for messages.
  std::string ValueText(const EstimatorOptions& options) const;
};

// All options, in the order in which they are checked.
std::span<const OptionSpec> OptionSpecs();

}  // namespace curvd
