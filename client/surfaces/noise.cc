#include "client/surfaces/noise.h"

#include <cstddef>

#include "client/surfaces/random.h"

namespace curv {
namespace {

constexpr uint64_t kPositionStream = 3;
constexpr uint64_t kNormalStream = 4;

void AddNoise(double sigma, const CounterRandom& random, std::vector<Vec3>& vectors) {
  for (size_t i = 0; i < vectors.size(); ++i) {
    for (uint64_t axis = 0; axis < 3; ++axis) {
      vectors[i][static_cast<int>(axis)] += sigma * random.Gaussian(3 * i + axis);
    }
  }
}

}  // namespace

void AddPositionNoise(double sigma, uint64_t seed, std::vector<Vec3>& positions) {
  AddNoise(sigma, CounterRandom(seed, kPositionStream), positions);
}

void AddNormalNoise(double sigma, uint64_t seed, std::vector<Vec3>& normals) {
  AddNoise(sigma, CounterRandom(seed, kNormalStream), normals);
  for (Vec3& normal : normals) normal = Normalized(normal);
}

}  // namespace curv
