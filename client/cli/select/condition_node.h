// The parts that a condition is made of.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "client/io/point_table.h"

namespace curv {

// Says of rows which number, or truth value (1 or 0), a part has.
class ConditionNode {
 public:
  enum class Type { kNumber, kTruth };
  enum class Operation {
    kAdd,
    kSubtract,
    kMultiply,
    kDivide,
    kLess,
    kLessEqual,
    kGreater,
    kGreaterEqual,
    kEqual,
    kNotEqual,
    kAnd,
    kOr
  };
  enum class Function { kNegate, kAbs, kNot };

  virtual ~ConditionNode() = default;

  virtual Type type() const = 0;
  // Replaces `values` with those of rows [begin, begin + count).
  virtual void Evaluate(size_t begin, size_t count, std::vector<double>& values) const = 0;
  // The column that the part is; null if it is anything else.
  virtual const Column* column() const { return nullptr; }

  static std::unique_ptr<ConditionNode> Constant(double number);
  // `column` must outlive the node.
  static std::unique_ptr<ConditionNode> Of(const Column& column);
  static std::unique_ptr<ConditionNode> Of(Function function, std::unique_ptr<ConditionNode> operand);
  static std::unique_ptr<ConditionNode> Of(Operation operation, std::unique_ptr<ConditionNode> left,
                                           std::unique_ptr<ConditionNode> right);
};

}  // namespace curv
