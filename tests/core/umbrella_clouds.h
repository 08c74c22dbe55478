// Clouds on which umbrellas may go wrong: lattices, circles, borders, doubles.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/core/test_clouds.h"

namespace curvd::testing {

struct NamedPoints {
  std::string name;
  TestPoints points;
};

// A few hundred points each, made anew for each seed where they are random; exact ties where they are not.
std::vector<NamedPoints> UmbrellaClouds(uint64_t seed);

}  // namespace curvd::testing
