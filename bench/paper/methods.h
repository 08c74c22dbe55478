// The estimators that the paper's figures compare.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/estimators/options.h"

namespace curvd::bench {

struct Method {
  std::string name;  // as in the CSV files: "uniform L=100"
  EstimatorOptions options;

  EstimatorOptions WithNeighbors(uint32_t k) const {
    EstimatorOptions result = options;
    result.neighborhood = NeighborCount{k};
    return result;
  }
};

// All of them, in the order of the figures' legends.
std::vector<Method> PaperMethods();

// The method of that name. REQUIRES: there is one.
Method MethodNamed(const std::string& name);

}  // namespace curvd::bench
