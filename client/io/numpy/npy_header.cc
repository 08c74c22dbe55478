#include "client/io/numpy/npy_header.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "client/io/bytes.h"
#include "client/io/point_table.h"
#include "client/io/text.h"

namespace curv {
namespace {

constexpr std::string_view kMagic("\x93NUMPY", 6);

absl::Status Error(const std::string& problem) { return absl::InvalidArgumentError(problem); }

// The product of a shape; none if it leaves 64 bits.
std::optional<uint64_t> Product(const std::vector<uint64_t>& shape) {
  uint64_t product = 1;
  for (const uint64_t length : shape) {
    if (length != 0 && product > std::numeric_limits<uint64_t>::max() / length) return std::nullopt;
    product *= length;
  }
  return product;
}

// Reads the header's text, a literal of Python: a dictionary with the keys descr, fortran_order and shape.
class LiteralParser {
 public:
  explicit LiteralParser(std::string_view text) : rest_(text), all_(text) {}

  absl::StatusOr<NpyHeader> Parse() {
    if (!Take('{')) return Expected("{");
    bool has_descr = false, has_order = false, has_shape = false;
    while (!Take('}')) {
      std::string key;
      if (!TakeString(key) || !Take(':')) return Expected("a key in quotes and a colon");
      absl::Status status;
      if (key == "descr") {
        has_descr = true;
        status = ParseDescription();
      } else if (key == "fortran_order") {
        has_order = TakeWord("True") || TakeWord("False");
        header_.fortran_order = last_word_ == "True";
        if (!has_order) status = Expected("True or False");
      } else if (key == "shape") {
        has_shape = TakeShape(header_.shape);
        if (!has_shape) status = Expected("a tuple of lengths");
      } else {
        status = Error(
            absl::StrCat("the header has an unknown key, ", Quoted(key), ": expected descr, fortran_order and shape"));
      }
      if (!status.ok()) return status;
      if (!Take(',') && !Peek('}')) return Expected(", or }");
    }
    if (!has_descr || !has_order || !has_shape) return Error("the header lacks descr, fortran_order or shape");
    return std::move(header_);
  }

 private:
  absl::Status Expected(const char* what) const {
    return Error(absl::StrCat("character ", all_.size() - rest_.size(), " of the header: expected ", what, ", found ",
                              Quoted(rest_.substr(0, 10))));
  }

  void SkipBlanks() { rest_.remove_prefix(std::min(rest_.find_first_not_of(" \t\n"), rest_.size())); }

  bool Peek(char c) {
    SkipBlanks();
    return !rest_.empty() && rest_.front() == c;
  }

  bool Take(char c) {
    if (!Peek(c)) return false;
    rest_.remove_prefix(1);
    return true;
  }

  bool TakeWord(std::string_view word) {
    SkipBlanks();
    if (rest_.substr(0, word.size()) != word) return false;
    rest_.remove_prefix(word.size());
    last_word_ = word;
    return true;
  }

  // A text in quotes. A backslash keeps the character after it.
  bool TakeString(std::string& text) {
    SkipBlanks();
    if (rest_.empty() || (rest_.front() != '\'' && rest_.front() != '"')) return false;
    const char quote = rest_.front();
    text.clear();
    for (size_t i = 1; i < rest_.size(); ++i) {
      if (rest_[i] == quote) {
        rest_.remove_prefix(i + 1);
        return true;
      }
      if (rest_[i] == '\\' && i + 1 < rest_.size()) ++i;
      text += rest_[i];
    }
    return false;
  }

  // A tuple of at most 32 lengths, as numpy has.
  bool TakeShape(std::vector<uint64_t>& shape) {
    constexpr size_t kMaxDimensions = 32;
    shape.clear();
    if (!Take('(')) return false;
    while (!Take(')')) {
      SkipBlanks();
      const size_t digits = std::min(rest_.find_first_not_of("0123456789"), rest_.size());
      uint64_t length;
      if (shape.size() == kMaxDimensions || !ParseNumber(rest_.substr(0, digits), length)) return false;
      rest_.remove_prefix(digits);
      Take('L');  // of Python 2
      shape.push_back(length);
      if (!Take(',') && !Peek(')')) return false;
    }
    return true;
  }

  // A type, or a list of (name, type) and (name, type, shape).
  absl::Status ParseDescription() {
    if (!Take('[')) {
      std::string type;
      if (!TakeString(type)) return Expected("a type in quotes, or a list of fields");
      return AddField("", type, {});
    }
    header_.structured = true;
    while (!Take(']')) {
      if (!Take('(')) return Expected("( before the name of a field");
      std::string name, type;
      // A pair instead of a name is a title and the name.
      if (Take('(')) {
        std::string title;
        if (!TakeString(title) || !Take(',') || !TakeString(name) || !Take(')')) return Expected("a title and a name");
      } else if (!TakeString(name)) {
        return Expected("the name of a field in quotes");
      }
      if (!Take(',')) return Expected(",");
      if (Peek('[')) {
        return Error(
            absl::StrCat("field ", Quoted(name), " is a structure of its own: expected a scalar, or an array"));
      }
      if (!TakeString(type)) return Expected("the type of a field in quotes");
      std::vector<uint64_t> shape;
      if (Take(',') && Peek('(') && !TakeShape(shape)) return Expected("the shape of a field");
      if (!Take(')')) return Expected(")");
      if (absl::Status status = AddField(name, type, std::move(shape)); !status.ok()) return status;
      if (!Take(',') && !Peek(']')) return Expected(", or ]");
    }
    return absl::OkStatus();
  }

  // A type is an order of bytes, a letter and the bytes, as "<f8"; what stands behind them are units of times.
  absl::Status AddField(const std::string& name, const std::string& type, std::vector<uint64_t> shape) {
    if (header_.fields.size() == kMaxColumns)
      return Error(absl::StrCat("there are more than ", kMaxColumns, " fields"));
    const std::string_view text = type;
    const bool has_order = !text.empty() && std::string_view("<>|=").find(text[0]) != std::string_view::npos;
    const std::string_view body = text.substr(has_order ? 1 : 0);
    NpyField field{.name = name,
                   .sort = body.empty() ? '?' : body[0],
                   .swap = has_order && text[0] == '>',
                   .shape = std::move(shape),
                   .offset = header_.element_bytes};
    if (field.sort == 'O')
      return Error(absl::StrCat("the array holds Python objects (", Quoted(type), "): they are not read"));
    uint32_t bytes = 0;
    const std::string_view digits = body.substr(std::min<size_t>(1, body.size()));
    if (!ParseNumber(digits.substr(0, digits.find('[')), bytes)) {
      return Error(absl::StrCat("type ", Quoted(type), " is not known: expected one as \"<f4\" or \">i2\""));
    }
    field.bytes = field.sort == 'U' ? size_t{4} * bytes : bytes;
    const std::optional<uint64_t> scalars = Product(field.shape);
    constexpr uint64_t kMostBytes = uint64_t{1} << 40;
    if (!scalars.has_value() || (field.bytes != 0 && *scalars > kMostBytes / field.bytes)) {
      return Error(
          absl::StrCat("field ", Quoted(name), " has the shape ", ShapeText(field.shape), ": it is too large"));
    }
    field.scalars = *scalars;
    header_.element_bytes += field.scalars * field.bytes;
    if (header_.element_bytes > kMostBytes) return Error("an element of the array is larger than 2^40 bytes");
    header_.fields.push_back(std::move(field));
    return absl::OkStatus();
  }

  std::string_view rest_;
  std::string_view all_;
  std::string_view last_word_;
  NpyHeader header_;
};

}  // namespace

bool NpyField::kept() const {
  switch (sort) {
    case 'f':
      return bytes == 4 || bytes == 8;
    case 'i':
    case 'u':
      return bytes == 1 || bytes == 2 || bytes == 4 || bytes == 8;
    default:
      return sort == 'b' && bytes == 1;
  }
}

std::string ShapeText(const std::vector<uint64_t>& shape) {
  std::string text = "(";
  for (size_t i = 0; i < shape.size(); ++i)
    absl::StrAppend(&text, i == 0 ? "" : " ", shape[i], i + 1 < shape.size() || i == 0 ? "," : "");
  return text + ")";
}

absl::StatusOr<NpyHeader> ReadNpyHeader(std::string_view file) {
  if (file.substr(0, kMagic.size()) != kMagic || file.size() < 12) {
    return Error("the file does not start as an array of numpy does, with 0x93 NUMPY and a version");
  }
  const auto major = unsigned{static_cast<unsigned char>(file[6])};
  if (major < 1 || major > 3) return Error(absl::StrCat("the format's version is ", major, ": expected 1 to 3"));
  const size_t text_at = major == 1 ? 10 : 12;
  const size_t text_bytes = major == 1 ? ScalarAt<uint16_t>(file, 8) : ScalarAt<uint32_t>(file, 8);
  if (text_bytes > file.size() - text_at) {
    return Error(absl::StrCat("the header has ", text_bytes, " bytes, only ", file.size() - text_at, " are left"));
  }
  absl::StatusOr<NpyHeader> header = LiteralParser(file.substr(text_at, text_bytes)).Parse();
  if (!header.ok()) return header.status();
  header->array_at = text_at + text_bytes;
  if (header->element_bytes == 0) return Error("the elements of the array have 0 bytes");
  const std::optional<uint64_t> elements = Product(header->shape);
  const size_t room = file.size() - header->array_at;
  if (!elements.has_value() || *elements > room / header->element_bytes) {
    return Error(absl::StrCat("the file ends too early: the shape is ", ShapeText(header->shape), ", ",
                              header->element_bytes, " bytes an element, but only ", room, " bytes follow the header"));
  }
  header->elements = *elements;
  return header;
}

}  // namespace curv
