#include "core/scale/parts/cloud_weights.h"

#include <algorithm>

namespace curvd {

CloudWeights::CloudWeights(const CloudChoice& choice) : choice_(choice), parts_(choice.samples(), choice.second()) {
  weights_.reserve(choice.parts().size());
  for (const PartChoice& part : choice.parts()) weights_.emplace_back(part.samples, part.choice);
}

void CloudWeights::Start(const Box& box) {
  parts_.Start(box);
  for (LocalWeights& weights : weights_) weights.Start(box);
}

CloudWeights::PointWeights CloudWeights::At(const float* position, size_t part) {
  PointWeights all{};
  const LocalWeights::PointWeights of_part = weights_[part].At(position);
  const size_t first = choice_.first_of(part), count = choice_.parts()[part].choice.chosen.size();
  std::copy_n(of_part.mean.begin(), count, all.mean.begin() + first);
  std::copy_n(of_part.traceless.begin(), count, all.traceless.begin() + first);
  std::copy_n(of_part.gaussian.begin(), count, all.gaussian.begin() + first);
  return all;
}

size_t CloudWeights::bytes() const {
  size_t bytes = parts_.bytes() + weights_.capacity() * sizeof(LocalWeights);
  for (const LocalWeights& weights : weights_) bytes += weights.bytes();
  return bytes;
}

}  // namespace curvd
