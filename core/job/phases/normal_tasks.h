// What a job wants of the normals of its cloud, whatever they are made of.
#pragma once

#include <optional>

#include "core/estimators/options.h"
#include "core/normals/normal_options.h"

namespace curvd {

struct NormalTasks {
  // Whether the normals in use are handed out, with their quality, at 24 bytes a point.
  bool returns_normals = false;
  // Whether normals that are estimated are made once more, each of its own half of the points alone, for estimates that
  // tell noise by halves (core/normals/runs/half_normals.h), at 12 bytes a point.
  bool makes_halves = false;
  // Whether given normals that prove to be fits to the positions are made anew where that is better, with makes_halves.
  bool makes_fits_anew = false;
};

// Those of an estimate whose caller wants normals like this. Without one, they are handed out in any case.
NormalTasks TasksFor(const std::optional<EstimatorOptions>& estimate, const NormalOptions& normals);

}  // namespace curvd
