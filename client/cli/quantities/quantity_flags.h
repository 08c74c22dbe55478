// The flags of `curv estimate` that say what is estimated.
#pragma once

#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "client/curvature_client.h"

namespace curv {

struct QuantityFlags {
  std::vector<std::string> only;  // by words of QuantityWords(); empty: not given
  std::vector<std::string> also;  // likewise, beside those
  std::string direction;          // X,Y,Z or an axis; empty: not given
  std::string direction_columns;  // NAME of NAMEx NAMEy NAMEz; empty: not given
};

// --quantities alone. `flags` must outlive `command`.
void AddQuantitiesFlag(CLI::App& command, QuantityFlags& flags);
// --quantities, --also, --direction and --direction-columns. `flags` must outlive `command`.
void AddQuantityFlags(CLI::App& command, QuantityFlags& flags);

// Sets what the flags say: a direction asks for normal_curvature. Throws CLI::ValidationError where a quantity lacks
// what it needs.
void ApplyQuantities(const QuantityFlags& flags, EstimateOptions& options);

// Adds a quantity, by a word of QuantityWords(), to those of a call, once.
void AddQuantity(const std::string& word, std::vector<std::string>& quantities);

}  // namespace curv
