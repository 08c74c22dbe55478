// A cloud whose sides are known, in units of the mean spacing of its points.
#pragma once

#include <string>

#include "bench/paper/samples.h"

namespace curvd::bench {

struct Shape {
  std::string name;
  Samples samples;
  bool is_open = false;
};

// Turns all about an axis that is no one's.
void Tilt(double angle, Samples& samples);

}  // namespace curvd::bench
