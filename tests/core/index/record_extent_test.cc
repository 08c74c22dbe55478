// The extent of records by vectors against one record at a time, on each instruction set that this machine has.
#include "core/index/record_extent.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <vector>

#include "tests/core/instruction_sets.h"

namespace curvd::testing {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

class RecordExtentTest : public InstructionSetTest {};
INSTANTIATE_TEST_SUITE_P(EachInstructionSet, RecordExtentTest, InstructionSets(), InstructionSetName);

TEST_P(RecordExtentTest, IsThatOfEachRecord) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> coordinate(-2.0f, 1.0f);
  for (size_t count = 0; count < 70; ++count) {
    std::vector<PointRecord> records(count);
    for (PointRecord& record : records) {
      record = {{coordinate(random), coordinate(random), coordinate(random)}, static_cast<int32_t>(random() >> 1)};
    }
    // A node that covers something already, and one that covers nothing.
    for (const float lo : {0.5f, kInfinity}) {
      TreeNode node{{{lo, lo, lo}, {-lo, -lo, -lo}}, 1 << 30, 0}, expected = node;
      for (const PointRecord& record : records) {
        for (int axis = 0; axis < 3; ++axis) {
          expected.box.lo[axis] = std::min(expected.box.lo[axis], record.position[axis]);
          expected.box.hi[axis] = std::max(expected.box.hi[axis], record.position[axis]);
        }
        expected.min_id = std::min(expected.min_id, record.id);
      }
      ExtendNode(records.data(), records.data() + count, node);
      EXPECT_EQ(node.box.lo, expected.box.lo) << count;
      EXPECT_EQ(node.box.hi, expected.box.hi) << count;
      EXPECT_EQ(node.min_id, expected.min_id) << count;
    }
  }
}

}  // namespace
}  // namespace curvd::testing
