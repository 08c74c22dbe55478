#include "client/cli/select/condition_node.h"

#include <cmath>
#include <variant>

namespace curv {
namespace {

using Type = ConditionNode::Type;
using Operation = ConditionNode::Operation;
using Function = ConditionNode::Function;

class ConstantNode : public ConditionNode {
 public:
  explicit ConstantNode(double number) : number_(number) {}
  Type type() const override { return Type::kNumber; }
  void Evaluate(size_t, size_t count, std::vector<double>& values) const override { values.assign(count, number_); }

 private:
  double number_;
};

class ColumnNode : public ConditionNode {
 public:
  explicit ColumnNode(const Column& column) : column_(column) {}
  Type type() const override { return Type::kNumber; }
  void Evaluate(size_t begin, size_t count, std::vector<double>& values) const override {
    values.resize(count);
    std::visit(
        [&](const auto& typed) {
          for (size_t i = 0; i < count; ++i) values[i] = static_cast<double>(typed[begin + i]);
        },
        column_.values);
  }
  const Column* column() const override { return &column_; }

 private:
  const Column& column_;
};

class FunctionNode : public ConditionNode {
 public:
  FunctionNode(Function function, std::unique_ptr<ConditionNode> operand)
      : function_(function), operand_(std::move(operand)) {}
  Type type() const override { return function_ == Function::kNot ? Type::kTruth : Type::kNumber; }
  void Evaluate(size_t begin, size_t count, std::vector<double>& values) const override {
    operand_->Evaluate(begin, count, values);
    for (double& value : values) {
      value = function_ == Function::kAbs ? std::abs(value) : function_ == Function::kNegate ? -value : 1.0 - value;
    }
  }

 private:
  Function function_;
  std::unique_ptr<ConditionNode> operand_;
};

double Apply(Operation operation, double a, double b) {
  switch (operation) {
    case Operation::kAdd:
      return a + b;
    case Operation::kSubtract:
      return a - b;
    case Operation::kMultiply:
      return a * b;
    case Operation::kDivide:
      return a / b;
    case Operation::kLess:
      return a < b ? 1.0 : 0.0;
    case Operation::kLessEqual:
      return a <= b ? 1.0 : 0.0;
    case Operation::kGreater:
      return a > b ? 1.0 : 0.0;
    case Operation::kGreaterEqual:
      return a >= b ? 1.0 : 0.0;
    case Operation::kEqual:
      return a == b ? 1.0 : 0.0;
    case Operation::kNotEqual:
      return a != b ? 1.0 : 0.0;
    case Operation::kAnd:
      return a * b;
    case Operation::kOr:
      return a + b > 0.0 ? 1.0 : 0.0;
  }
  return 0.0;
}

class OperationNode : public ConditionNode {
 public:
  OperationNode(Operation operation, std::unique_ptr<ConditionNode> left, std::unique_ptr<ConditionNode> right)
      : operation_(operation), left_(std::move(left)), right_(std::move(right)) {}
  Type type() const override { return operation_ >= Operation::kLess ? Type::kTruth : Type::kNumber; }
  void Evaluate(size_t begin, size_t count, std::vector<double>& values) const override {
    std::vector<double> right;
    left_->Evaluate(begin, count, values);
    right_->Evaluate(begin, count, right);
    for (size_t i = 0; i < count; ++i) values[i] = Apply(operation_, values[i], right[i]);
  }

 private:
  Operation operation_;
  std::unique_ptr<ConditionNode> left_;
  std::unique_ptr<ConditionNode> right_;
};

}  // namespace

std::unique_ptr<ConditionNode> ConditionNode::Constant(double number) { return std::make_unique<ConstantNode>(number); }

std::unique_ptr<ConditionNode> ConditionNode::Of(const Column& column) { return std::make_unique<ColumnNode>(column); }

std::unique_ptr<ConditionNode> ConditionNode::Of(Function function, std::unique_ptr<ConditionNode> operand) {
  return std::make_unique<FunctionNode>(function, std::move(operand));
}

std::unique_ptr<ConditionNode> ConditionNode::Of(Operation operation, std::unique_ptr<ConditionNode> left,
                                                 std::unique_ptr<ConditionNode> right) {
  return std::make_unique<OperationNode>(operation, std::move(left), std::move(right));
}

}  // namespace curv
