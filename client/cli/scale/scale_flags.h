// The flags of `curv estimate` that say how large neighborhoods are.
#pragma once

#include <string>

#include "CLI/CLI.hpp"
#include "client/curvature_client.h"

namespace curv {

struct ScaleFlags {
  std::string k;  // empty: not given
  double radius = 0.0;
  bool automatic = false;  // estimator and scale
  std::string range;       // LEAST:MOST; empty: not given
  double max_radius = 0.0;
  bool per_cloud = false;
};

// REQUIRES: the command has --estimator.
void AddScaleFlags(CLI::App& command, ScaleFlags& flags);

// Sets what the flags say. Throws CLI::ValidationError where they contradict each other.
void ApplyScale(const ScaleFlags& flags, EstimateOptions& options);

}  // namespace curv
