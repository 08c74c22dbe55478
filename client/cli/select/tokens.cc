#include "client/cli/select/tokens.h"

#include <charconv>
#include <system_error>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "client/io/text.h"

namespace curv {
namespace {

constexpr std::string_view kSigns[] = {"<=", ">=", "==", "!=", "<", ">", "+", "-", "*", "/", "(", ")"};
// What other languages write.
constexpr std::pair<std::string_view, const char*> kMeant[] = {{"&&", "and"}, {"||", "or"}, {"&", "and"},
                                                               {"|", "or"},   {"!", "not"}, {"=", "=="}};

bool IsNameStart(char c) { return absl::ascii_isalpha(static_cast<unsigned char>(c)) || c == '_'; }
bool IsDigit(char c) { return c >= '0' && c <= '9'; }

// Reads one token after the other.
class Tokenizer {
 public:
  explicit Tokenizer(std::string_view condition) : condition_(condition) {}

  absl::StatusOr<std::vector<Token>> Read() {
    std::vector<Token> tokens;
    while (SkipBlanks()) {
      absl::StatusOr<Token> token = Next();
      if (!token.ok()) return token.status();
      tokens.push_back(*std::move(token));
    }
    tokens.emplace_back().at = at_ + 1;
    return tokens;
  }

 private:
  std::string_view rest() const { return condition_.substr(at_); }

  bool SkipBlanks() {
    while (at_ < condition_.size() && (IsBlank(condition_[at_]) || condition_[at_] == '\n')) ++at_;
    return at_ < condition_.size();
  }

  absl::StatusOr<Token> Next() {
    const char first = condition_[at_];
    if (IsDigit(first) || first == '.') return Number();
    if (IsNameStart(first)) return Name();
    if (first == '"' || first == '`') return QuotedName(first);
    for (const std::string_view sign : kSigns) {
      if (rest().substr(0, sign.size()) == sign) return Take(Token::Kind::kSign, sign.size());
    }
    for (const auto& [other, ours] : kMeant) {
      if (rest().substr(0, other.size()) == other) {
        return ConditionError(at_ + 1, absl::StrCat(Quoted(other), " is not known: write ", ours));
      }
    }
    if (first == '\'')
      return ConditionError(at_ + 1, "words and columns stand without single quotes: write status == ok");
    if (static_cast<unsigned char>(first) >= 0x80) {
      return ConditionError(
          at_ + 1,
          "columns with other characters than letters, digits and _ stand in double quotes: \"echo width\" > 3");
    }
    return ConditionError(at_ + 1, absl::StrCat("found ", Quoted(rest().substr(0, 1)),
                                                ": expected a column, a number, a comparison or a parenthesis"));
  }

  Token Take(Token::Kind kind, size_t size) {
    Token token{.kind = kind, .text = std::string(rest().substr(0, size)), .at = at_ + 1};
    at_ += size;
    return token;
  }

  absl::StatusOr<Token> Number() {
    double number = 0.0;
    const std::string_view text = rest();
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    const auto size = static_cast<size_t>(stop - text.data());
    const bool ends = size == text.size() || !(IsNameStart(*stop) || IsDigit(*stop) || *stop == '.');
    if (error != std::errc() || !ends) {
      return ConditionError(at_ + 1, absl::StrCat("expected a number in the range of double, found ",
                                                  Quoted(text.substr(0, text.find_first_of(" ()<>=!+*/")))));
    }
    Token token = Take(Token::Kind::kNumber, size);
    token.number = number;
    return token;
  }

  Token Name() {
    size_t size = 1;
    while (size < rest().size() && (IsNameStart(rest()[size]) || IsDigit(rest()[size]))) ++size;
    return Take(Token::Kind::kName, size);
  }

  absl::StatusOr<Token> QuotedName(char quote) {
    const size_t end = rest().find(quote, 1);
    if (end == std::string_view::npos) return ConditionError(at_ + 1, "the quotes around a column are not closed");
    Token token = Take(Token::Kind::kName, end + 1);
    token.text = token.text.substr(1, end - 1);
    token.quoted = true;
    return token;
  }

  std::string_view condition_;
  size_t at_ = 0;
};

}  // namespace

absl::StatusOr<std::vector<Token>> Tokenize(std::string_view condition) { return Tokenizer(condition).Read(); }

absl::Status ConditionError(size_t at, const std::string& problem) {
  return absl::InvalidArgumentError(absl::StrCat("character ", at, ": ", problem));
}

}  // namespace curv
