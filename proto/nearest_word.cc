#include "proto/nearest_word.h"

#include <algorithm>
#include <cstddef>
#include <numeric>

namespace curvd {
namespace {

// Longer words are no names, and would take long.
constexpr size_t kMostLetters = 64;

}  // namespace

size_t EditDistance(std::string_view word, std::string_view other) {
  std::vector<size_t> before(other.size() + 1), row(other.size() + 1), next(other.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 1; i <= word.size(); ++i) {
    next[0] = i;
    for (size_t j = 1; j <= other.size(); ++j) {
      next[j] = std::min({row[j] + 1, next[j - 1] + 1, row[j - 1] + (word[i - 1] == other[j - 1] ? 0 : 1)});
      const bool are_exchanged = i > 1 && j > 1 && word[i - 1] == other[j - 2] && word[i - 2] == other[j - 1];
      if (are_exchanged) next[j] = std::min(next[j], before[j - 2] + 1);
    }
    before.swap(row);
    row.swap(next);
  }
  return row.back();
}

std::string NearestWord(std::string_view word, const std::vector<std::string>& known) {
  if (word.size() > kMostLetters) return "";
  std::string nearest;
  size_t least = std::max<size_t>(2, word.size() / 3) + 1;
  for (const std::string& other : known) {
    if (const size_t distance = EditDistance(word, other); distance < least) {
      least = distance;
      nearest = other;
    }
  }
  return nearest;
}

std::string DidYouMean(std::string_view word, const std::vector<std::string>& known) {
  const std::string nearest = NearestWord(word, known);
  return nearest.empty() ? "" : "; did you mean " + nearest + "?";
}

}  // namespace curvd
