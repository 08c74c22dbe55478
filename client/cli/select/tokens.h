// Cuts a condition over columns into words, numbers and signs.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace curv {

struct Token {
  enum class Kind { kNumber, kName, kSign, kEnd };

  Kind kind = Kind::kEnd;
  std::string text;     // of a name without its quotes
  double number = 0.0;  // of a number
  bool quoted = false;  // whether a name stood in quotes, and is no keyword
  size_t at = 0;        // character of the condition, counted from 1
};

// Returns the tokens of a condition, and kEnd behind them. Names are letters, digits and _, not starting with a digit,
// or anything in double quotes; signs are < <= > >= == != + - * / ( and ). INVALID_ARGUMENT naming the character if
// anything else stands there; it says what is meant by = && || and !.
absl::StatusOr<std::vector<Token>> Tokenize(std::string_view condition);

// INVALID_ARGUMENT with the character in front of the problem.
absl::Status ConditionError(size_t at, const std::string& problem);

}  // namespace curv
