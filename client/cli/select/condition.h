// A condition over the columns of a table, as `curv select --where` takes it.
#pragma once

#include <cstddef>
#include <memory>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "client/io/point_table.h"

namespace curv {

class ConditionNode;

// Const methods are thread-safe.
class Condition {
 public:
  // Parses a condition: comparisons < <= > >= == != of numbers, joined by and, or, not and parentheses ("not" binds
  // tighter than "and", that tighter than "or"). Numbers are columns, constants, and what + - * / and abs() make of
  // them, in doubles. The words of PointStatus ("ok", "singular_fit") stand for their values beside the column
  // `status`, with == or !=. A column whose name is a keyword, or has other characters than letters, digits and _,
  // stands in double quotes. INVALID_ARGUMENT naming the character if the text is anything else; NOT_FOUND for an
  // unknown column, with those that there are. `table` must outlive the condition.
  static absl::StatusOr<Condition> Parse(std::string_view text, const PointTable& table);

  Condition(Condition&&) noexcept;
  Condition& operator=(Condition&&) noexcept;
  ~Condition();

  // Returns the rows for which it holds, in order. Comparisons with NaN do not hold, but for !=.
  std::vector<size_t> Rows() const;

 private:
  Condition(std::unique_ptr<ConditionNode> root, size_t rows);

  std::unique_ptr<ConditionNode> root_;
  size_t rows_;
};

// Returns a table of these rows, in their order, with all that the table says beside its columns; the grid of an
// organized cloud only with all rows.
// REQUIRES: each is less than table.size().
PointTable SelectRows(const PointTable& table, const std::vector<size_t>& rows);

}  // namespace curv
