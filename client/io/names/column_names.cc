#include "client/io/names/column_names.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <numeric>
#include <set>

#include "absl/status/status.h"
#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "client/io/text.h"

namespace curv {
namespace {

constexpr std::array<std::string_view, 6> kPlain = {"x", "y", "z", "nx", "ny", "nz"};

}  // namespace

std::string TableName(std::string_view spelling) {
  const std::string lower = absl::AsciiStrToLower(std::string(spelling));
  if (lower.empty() || lower.back() < 'x' || lower.back() > 'z') return std::string(spelling);
  const std::string_view before = std::string_view(lower).substr(0, lower.size() - 1);
  if (before.empty()) return lower;
  for (const std::string_view normal : {"n", "n_", "normal", "normal_"}) {
    if (before == normal) return std::string("n") + lower.back();
  }
  return std::string(spelling);
}

absl::StatusOr<std::vector<std::string>> TableNames(const std::vector<std::string>& spellings, const char* what) {
  std::vector<std::string> names;
  std::map<std::string, std::string_view> spelled;
  for (const std::string& spelling : spellings) {
    names.push_back(TableName(spelling));
    const auto [first, is_new] = spelled.try_emplace(names.back(), spelling);
    if (is_new) continue;
    if (first->second == spelling) {
      return absl::InvalidArgumentError(absl::StrCat("two ", what, " have the name ", Quoted(spelling)));
    }
    return absl::InvalidArgumentError(absl::StrCat("two ", what, " have the name ", Quoted(names.back()), ": ",
                                                   Quoted(first->second), " and ", Quoted(spelling),
                                                   ": rename or remove one"));
  }
  return names;
}

std::vector<std::string> HeaderNames(const PointTable& table, std::string (*clean)(std::string_view name)) {
  const std::vector<Column>& columns = table.columns();
  const auto rank = [&](size_t i) {
    const std::string& name = columns[i].name;
    const bool is_kept = clean(name) == name, is_plain = std::find(kPlain.begin(), kPlain.end(), name) != kPlain.end();
    return is_plain ? 0 : is_kept ? 1 : 2;
  };
  std::vector<size_t> order(columns.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return rank(a) < rank(b); });
  std::vector<std::string> names(columns.size());
  std::set<std::string> used;
  for (const size_t i : order) {
    std::string first = clean(columns[i].name);
    if (first.empty()) first = "column";
    names[i] = first;
    for (int number = 2; !used.insert(TableName(names[i])).second; ++number) {
      names[i] = absl::StrCat(first, "_", number);
    }
  }
  return names;
}

}  // namespace curv
