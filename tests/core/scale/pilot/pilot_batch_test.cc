#include "core/scale/pilot/pilot_batch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>
#include <vector>

#include "tests/core/instruction_sets.h"

namespace curvd::testing {
namespace {

constexpr size_t kPlaces = MonomialCount(2 * PilotMoments::kMostDegree);

struct Sums {
  std::array<std::array<double, kPlaces>, 5> of{};  // plain, of heights, of normals

  void Add(PilotBatch& batch, int degree, int normal_degree, bool with_heights) {
    AddMoments(batch, {degree,
                       normal_degree,
                       of[0].data(),
                       with_heights ? of[1].data() : nullptr,
                       {of[2].data(), of[3].data(), of[4].data()}});
  }
};

std::vector<PilotNeighbor> RandomNeighbors(size_t count) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> coordinate(-1.0, 1.0);
  std::vector<PilotNeighbor> neighbors(count);
  for (PilotNeighbor& neighbor : neighbors) {
    for (size_t axis = 0; axis < 3; ++axis) {
      neighbor.offset[axis] = coordinate(random);
      neighbor.normal[axis] = coordinate(random);
    }
  }
  return neighbors;
}

PilotBatch BatchOf(const std::vector<PilotNeighbor>& neighbors) {
  PilotBatch batch;
  // What is there before, and beyond the last neighbor, must not count.
  for (PilotBatch::Column* const column : {&batch.one, &batch.offset[0], &batch.offset[1], &batch.offset[2],
                                           &batch.normal[0], &batch.normal[1], &batch.normal[2]}) {
    column->fill(7.0);
  }
  for (const PilotNeighbor& neighbor : neighbors) batch.Add(neighbor);
  return batch;
}

class PilotBatchTest : public InstructionSetTest {};

struct Asked {
  int degree, normal_degree;
  bool with_heights;
};

TEST_P(PilotBatchTest, AddsTheMonomialsOfEachNeighbor) {
  for (const size_t count : {size_t{1}, size_t{7}, size_t{8}, size_t{61}, PilotBatch::kMost}) {
    const std::vector<PilotNeighbor> neighbors = RandomNeighbors(count);
    for (const auto& [degree, normal_degree, with_heights] :
         {Asked{4, 5, true}, Asked{6, 5, true}, Asked{2, 2, false}, Asked{6, 1, false}}) {
      PilotBatch batch = BatchOf(neighbors);
      Sums sums;
      sums.Add(batch, degree, normal_degree, with_heights);
      for (int n = 0, place = 0; n <= 2 * degree; ++n) {
        for (int j = 0; j <= n; ++j, ++place) {
          std::array<double, 5> expected{};
          for (const auto& [offset, normal] : neighbors) {
            const double monomial = std::pow(offset[0], n - j) * std::pow(offset[1], j);
            expected[0] += monomial;
            if (with_heights && n <= degree) expected[1] += monomial * offset[2];
            for (size_t axis = 0; axis < 3; ++axis) {
              if (n <= normal_degree) expected[2 + axis] += monomial * normal[axis];
            }
          }
          for (size_t kind = 0; kind < 5; ++kind) {
            if (kind == 1 && n > degree) continue;
            // A few dozen roundings of sums of at most `count` numbers below 1.
            EXPECT_NEAR(sums.of[kind][static_cast<size_t>(place)], expected[kind], 1e-14 * static_cast<double>(count))
                << kind << " " << n << " " << j << " " << count;
          }
        }
      }
    }
  }
}

TEST_P(PilotBatchTest, SumsAreTheSameOnEveryInstructionSet) {
  const std::vector<PilotNeighbor> neighbors = RandomNeighbors(101);
  PilotBatch batch = BatchOf(neighbors);
  Sums here, anywhere;
  here.Add(batch, PilotMoments::kMostDegree, 5, true);
  hwy::SetSupportedTargetsForTest(0);
  anywhere.Add(batch, PilotMoments::kMostDegree, 5, true);
  EXPECT_EQ(std::memcmp(&here, &anywhere, sizeof(here)), 0);
}

INSTANTIATE_TEST_SUITE_P(All, PilotBatchTest, InstructionSets(), InstructionSetName);

}  // namespace
}  // namespace curvd::testing
