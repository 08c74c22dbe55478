// What is judged and weighed apart, since what suits one need not suit the others.
#pragma once

namespace curvd {

template <typename Value>
struct OfQuantities {
  Value mean{};       // curvature: half the trace of the shape operator
  Value traceless{};  // the shape operator without its trace: half of k2 - k1, and the principal directions
  Value gaussian{};   // curvature
};

}  // namespace curvd
