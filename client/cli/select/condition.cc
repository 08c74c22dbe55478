#include "client/cli/select/condition.h"

#include <algorithm>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>

#include "absl/status/status.h"
#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "client/cli/select/condition_node.h"
#include "client/cli/select/tokens.h"
#include "client/io/point_status.h"
#include "client/io/text.h"

namespace curv {
namespace {

using Node = std::unique_ptr<ConditionNode>;
using Type = ConditionNode::Type;
using Operation = ConditionNode::Operation;
using Function = ConditionNode::Function;

constexpr std::pair<std::string_view, Operation> kComparisons[] = {
    {"<", Operation::kLess},          {"<=", Operation::kLessEqual}, {">", Operation::kGreater},
    {">=", Operation::kGreaterEqual}, {"==", Operation::kEqual},     {"!=", Operation::kNotEqual}};
// Each level calls a handful of functions, so that no text can exhaust the stack.
constexpr int kMaxDepth = 200;
constexpr size_t kMaxTokens = 10'000;

// A part of the text, and whether it is the word of a status, which can stand beside that column alone.
struct Part {
  Node node;
  size_t at = 0;
  std::string status_word{};
};

// A recursive descent; each function reads what binds tighter than its caller's signs.
class Parser {
 public:
  Parser(std::vector<Token> tokens, const PointTable& table) : tokens_(std::move(tokens)), table_(table) {}

  absl::StatusOr<Node> Parse() {
    absl::StatusOr<Part> part = Or();
    if (!part.ok()) return part.status();
    if (token().kind != Token::Kind::kEnd) return Unexpected("and, or, or the end");
    if (absl::Status status = Want(Type::kTruth, *part); !status.ok()) return status;
    return std::move(part->node);
  }

 private:
  const Token& token() const { return tokens_[next_]; }

  bool Is(std::string_view word) const {
    return token().kind != Token::Kind::kNumber && !token().quoted && token().text == word;
  }

  bool Take(std::string_view word) {
    if (!Is(word)) return false;
    ++next_;
    return true;
  }

  absl::Status Unexpected(const std::string& expected) const {
    const std::string found = token().kind == Token::Kind::kEnd ? "the end" : Quoted(token().text);
    return ConditionError(token().at, absl::StrCat("expected ", expected, ", found ", found));
  }

  static absl::Status Want(Type type, const Part& part) {
    if (!part.status_word.empty()) {
      return ConditionError(part.at, absl::StrCat(part.status_word,
                                                  " is a status: compare it with the column status, by "
                                                  "== or !="));
    }
    if (part.node->type() == type) return absl::OkStatus();
    return ConditionError(part.at, type == Type::kTruth ? "expected a comparison, as k2 > 0.5, found a number"
                                                        : "expected a number, found a comparison");
  }

  // Joins two parts of a type.
  static absl::StatusOr<Part> Join(Operation operation, Type type, absl::StatusOr<Part> left,
                                   absl::StatusOr<Part> right) {
    if (!right.ok()) return right.status();
    for (const Part* part : {&*left, &*right}) {
      if (absl::Status status = Want(type, *part); !status.ok()) return status;
    }
    const size_t at = left->at;
    return Part{ConditionNode::Of(operation, std::move(left->node), std::move(right->node)), at};
  }

  absl::StatusOr<Part> Or() {
    absl::StatusOr<Part> left = And();
    while (left.ok() && Take("or")) left = Join(Operation::kOr, Type::kTruth, std::move(left), And());
    return left;
  }

  absl::StatusOr<Part> And() {
    absl::StatusOr<Part> left = Not();
    while (left.ok() && Take("and")) left = Join(Operation::kAnd, Type::kTruth, std::move(left), Not());
    return left;
  }

  absl::StatusOr<Part> Not() {
    const size_t at = token().at;
    if (!Take("not")) return Comparison();
    return Nested([&]() -> absl::StatusOr<Part> {
      absl::StatusOr<Part> operand = Not();
      if (!operand.ok()) return operand;
      if (absl::Status status = Want(Type::kTruth, *operand); !status.ok()) return status;
      return Part{ConditionNode::Of(Function::kNot, std::move(operand->node)), at};
    });
  }

  absl::StatusOr<Part> Comparison() {
    absl::StatusOr<Part> left = Sum();
    if (!left.ok()) return left;
    const std::optional<Operation> operation = TakeComparison();
    if (!operation.has_value()) return left;
    absl::StatusOr<Part> right = Sum();
    if (!right.ok()) return right;
    const bool is_equality = *operation == Operation::kEqual || *operation == Operation::kNotEqual;
    ResolveStatus(is_equality, *left, *right);
    ResolveStatus(is_equality, *right, *left);
    absl::StatusOr<Part> joined = Join(*operation, Type::kNumber, std::move(left), std::move(right));
    if (joined.ok() && TakeComparison().has_value()) {
      --next_;
      return ConditionError(token().at, "comparisons cannot be chained: write a < b and b < c");
    }
    return joined;
  }

  std::optional<Operation> TakeComparison() {
    for (const auto& [sign, operation] : kComparisons) {
      if (Take(sign)) return operation;
    }
    return std::nullopt;
  }

  // Takes a word beside a column of statuses for its value.
  static void ResolveStatus(bool is_equality, const Part& other, Part& part) {
    const Column* const column = other.node->column();
    if (is_equality && column != nullptr && IsStatusName(column->name)) part.status_word.clear();
  }

  absl::StatusOr<Part> Sum() {
    absl::StatusOr<Part> left = Product();
    while (left.ok() && (Is("+") || Is("-"))) {
      const Operation operation = Is("+") ? Operation::kAdd : Operation::kSubtract;
      ++next_;
      left = Join(operation, Type::kNumber, std::move(left), Product());
    }
    return left;
  }

  absl::StatusOr<Part> Product() {
    absl::StatusOr<Part> left = Signed();
    while (left.ok() && (Is("*") || Is("/"))) {
      const Operation operation = Is("*") ? Operation::kMultiply : Operation::kDivide;
      ++next_;
      left = Join(operation, Type::kNumber, std::move(left), Signed());
    }
    return left;
  }

  absl::StatusOr<Part> Signed() {
    const size_t at = token().at;
    const bool is_negative = Is("-");
    if (!is_negative && !Is("+")) return Primary();
    ++next_;
    return Nested([&]() -> absl::StatusOr<Part> {
      absl::StatusOr<Part> operand = Signed();
      if (!operand.ok()) return operand;
      if (absl::Status status = Want(Type::kNumber, *operand); !status.ok()) return status;
      if (!is_negative) return operand;
      return Part{ConditionNode::Of(Function::kNegate, std::move(operand->node)), at};
    });
  }

  absl::StatusOr<Part> Primary() {
    const Token first = token();
    if (Take("(")) return Nested([this] { return Closed(); });
    if (first.kind == Token::Kind::kNumber) {
      ++next_;
      return Part{ConditionNode::Constant(first.number), first.at};
    }
    const bool is_keyword = Is("and") || Is("or") || Is("not");
    if (first.kind != Token::Kind::kName || is_keyword) return Unexpected("a column, a number or a parenthesis");
    ++next_;
    if (!first.quoted && first.text == "abs" && Take("(")) {
      return Nested([&]() -> absl::StatusOr<Part> {
        absl::StatusOr<Part> operand = Closed();
        if (!operand.ok()) return operand;
        if (absl::Status status = Want(Type::kNumber, *operand); !status.ok()) return status;
        return Part{ConditionNode::Of(Function::kAbs, std::move(operand->node)), first.at};
      });
    }
    return Named(first);
  }

  // What stands before a closing parenthesis.
  absl::StatusOr<Part> Closed() {
    absl::StatusOr<Part> inside = Or();
    if (inside.ok() && !Take(")")) return Unexpected(")");
    return inside;
  }

  static std::string HintAtStatus(const std::string& name) {
    const std::string word = absl::AsciiStrToLower(name);
    return StatusOfWord(word).has_value() ? absl::StrCat("; the word of a status is ", word, ", without quotes") : "";
  }

  absl::StatusOr<Part> Named(const Token& name) const {
    if (const Column* column = table_.Find(name.text)) return Part{ConditionNode::Of(*column), name.at};
    const std::optional<uint8_t> status = StatusOfWord(name.text);
    if (status.has_value() && !name.quoted) return Part{ConditionNode::Constant(*status), name.at, name.text};
    std::string columns;
    for (const Column& column : table_.columns()) absl::StrAppend(&columns, " ", Printable(column.name));
    const absl::Status error = ConditionError(
        name.at,
        absl::StrCat("there is no column ", Quoted(name.text), HintAtStatus(name.text), ". The columns are:", columns));
    return absl::NotFoundError(error.message());
  }

  template <typename Read>
  absl::StatusOr<Part> Nested(const Read& read) {
    if (depth_ == kMaxDepth) {
      return ConditionError(token().at, absl::StrCat("more than ", kMaxDepth, " levels of parentheses and signs"));
    }
    ++depth_;
    absl::StatusOr<Part> part = read();
    --depth_;
    return part;
  }

  std::vector<Token> tokens_;
  const PointTable& table_;
  size_t next_ = 0;
  int depth_ = 0;
};

}  // namespace

Condition::Condition(std::unique_ptr<ConditionNode> root, size_t rows) : root_(std::move(root)), rows_(rows) {}
Condition::Condition(Condition&&) noexcept = default;
Condition& Condition::operator=(Condition&&) noexcept = default;
Condition::~Condition() = default;

absl::StatusOr<Condition> Condition::Parse(std::string_view text, const PointTable& table) {
  absl::StatusOr<std::vector<Token>> tokens = Tokenize(text);
  if (!tokens.ok()) return tokens.status();
  if (tokens->size() > kMaxTokens) {
    return absl::InvalidArgumentError(
        absl::StrCat("the condition has ", tokens->size(), " words and signs: expected at most ", kMaxTokens));
  }
  absl::StatusOr<Node> root = Parser(*std::move(tokens), table).Parse();
  if (!root.ok()) return root.status();
  return Condition(*std::move(root), table.size());
}

std::vector<size_t> Condition::Rows() const {
  constexpr size_t kBlockRows = 4096;
  std::vector<size_t> rows;
  std::vector<double> holds;
  for (size_t begin = 0; begin < rows_; begin += kBlockRows) {
    root_->Evaluate(begin, std::min(kBlockRows, rows_ - begin), holds);
    for (size_t i = 0; i < holds.size(); ++i) {
      if (holds[i] != 0.0) rows.push_back(begin + i);
    }
  }
  return rows;
}

PointTable SelectRows(const PointTable& table, const std::vector<size_t>& rows) {
  PointTable selected;
  selected.viewpoint = table.viewpoint;
  selected.pcd.rotation = table.pcd.rotation;
  if (rows.size() == table.size()) selected.pcd = table.pcd;
  selected.las = table.las;
  for (const Column& column : table.columns()) {
    std::visit(
        [&](const auto& values) {
          std::decay_t<decltype(values)> kept;
          kept.reserve(rows.size());
          for (const size_t row : rows) kept.push_back(values[row]);
          selected.Set({column.name, std::move(kept)});
        },
        column.values);
  }
  return selected;
}

}  // namespace curv
