#include "client/io/ply_header.h"

#include <algorithm>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "client/io/text.h"

namespace curv {
namespace {

constexpr std::pair<std::string_view, ScalarKind> kTypes[] = {
    {"char", ScalarKind::kInt8},      {"uchar", ScalarKind::kUint8},    {"short", ScalarKind::kInt16},
    {"ushort", ScalarKind::kUint16},  {"int", ScalarKind::kInt32},      {"uint", ScalarKind::kUint32},
    {"float", ScalarKind::kFloat32},  {"double", ScalarKind::kFloat64}, {"int8", ScalarKind::kInt8},
    {"uint8", ScalarKind::kUint8},    {"int16", ScalarKind::kInt16},    {"uint16", ScalarKind::kUint16},
    {"int32", ScalarKind::kInt32},    {"uint32", ScalarKind::kUint32},  {"float32", ScalarKind::kFloat32},
    {"float64", ScalarKind::kFloat64}};

std::optional<ScalarKind> TypeOf(std::string_view word) {
  for (const auto& [name, kind] : kTypes) {
    if (name == word) return kind;
  }
  return std::nullopt;
}

// Some programs leave blanks at the ends of lines.
bool IsFirstLine(std::string_view line) {
  constexpr std::string_view kWord = "ply";
  if (!line.starts_with(kWord)) return false;
  const std::string_view rest = line.substr(kWord.size());
  return std::all_of(rest.begin(), rest.end(), IsBlank);
}

// Reads the header line by line.
class HeaderParser {
 public:
  explicit HeaderParser(std::string_view bytes) : lines_(WithoutByteOrderMark(bytes)), bytes_(bytes.size()) {}

  absl::StatusOr<PlyHeader> Parse() {
    std::string_view line;
    if (!lines_.Next(line) || !IsFirstLine(line))
      return Error("expected the word ply, as the first line of a PLY file");
    while (lines_.Next(line)) {
      std::string_view rest = line;
      const std::string_view keyword = NextField(rest);
      if (keyword == "end_header") return End();
      if (absl::Status status = ParseLine(keyword, rest); !status.ok()) return status;
    }
    return Error("the header does not end: expected end_header");
  }

 private:
  absl::Status Error(const std::string& problem) const {
    return absl::InvalidArgumentError(absl::StrCat("line ", std::max<size_t>(1, lines_.number()), ": ", problem));
  }

  absl::Status ParseLine(std::string_view keyword, std::string_view rest) {
    if (keyword.empty() || keyword == "comment" || keyword == "obj_info") return absl::OkStatus();
    if (keyword == "format") return ParseFormat(rest);
    if (keyword == "element") return ParseElement(rest);
    if (keyword == "property") return ParseProperty(rest);
    return Error(absl::StrCat("unknown keyword ", Quoted(keyword),
                              ": expected format, comment, element, property or end_header"));
  }

  absl::Status ParseFormat(std::string_view rest) {
    const std::string_view name = NextField(rest);
    if (name == "ascii") {
      format_ = PlyFormat::kAscii;
    } else if (name == "binary_little_endian") {
      format_ = PlyFormat::kLittleEndian;
    } else if (name == "binary_big_endian") {
      format_ = PlyFormat::kBigEndian;
    } else {
      return Error(
          absl::StrCat("unknown format ", Quoted(name), ": expected ascii, binary_little_endian or binary_big_endian"));
    }
    const std::string_view version = NextField(rest);
    if (version != "1.0") return Error(absl::StrCat("unknown version ", Quoted(version), ": expected 1.0"));
    return absl::OkStatus();
  }

  absl::Status ParseElement(std::string_view rest) {
    const std::string_view name = NextField(rest);
    const std::string_view count = NextField(rest);
    PlyElement element{.name = std::string(name), .count = 0, .properties = {}};
    if (name.empty() || !ParseNumber(count, element.count)) {
      return Error(
          absl::StrCat("expected a name and a count after element, found ", Quoted(name), " and ", Quoted(count)));
    }
    elements_.push_back(std::move(element));
    return absl::OkStatus();
  }

  absl::Status ParseProperty(std::string_view rest) {
    if (elements_.empty()) return Error("a property comes before any element");
    std::string_view type = NextField(rest);
    std::optional<ScalarKind> count_kind;
    if (type == "list") {
      const std::string_view count_type = NextField(rest);
      count_kind = TypeOf(count_type);
      if (!count_kind || *count_kind >= ScalarKind::kFloat32) {
        return Error(absl::StrCat("the length of a list has type ", Quoted(count_type), ": expected an integer type"));
      }
      type = NextField(rest);
    }
    const std::optional<ScalarKind> kind = TypeOf(type);
    if (!kind)
      return Error(absl::StrCat("unknown type ", Quoted(type), ": expected char to double or int8 to float64"));
    const std::string_view name = NextField(rest);
    if (name.empty()) return Error("a property has no name");
    std::vector<PlyProperty>& properties = elements_.back().properties;
    if (properties.size() == kMaxColumns) {
      return Error(absl::StrCat("an element has more than ", kMaxColumns, " properties"));
    }
    for (const PlyProperty& other : properties) {
      if (other.name == name) return Error(absl::StrCat("property ", Quoted(name), " is declared twice"));
    }
    properties.push_back({std::string(name), *kind, count_kind});
    return absl::OkStatus();
  }

  absl::StatusOr<PlyHeader> End() {
    if (!format_) return Error("the header names no format");
    return PlyHeader{*format_, std::move(elements_), bytes_ - lines_.rest().size(), lines_.number()};
  }

  LineReader lines_;
  size_t bytes_;
  std::optional<PlyFormat> format_;
  std::vector<PlyElement> elements_;
};

}  // namespace

bool PlyElement::has_lists() const {
  return std::any_of(properties.begin(), properties.end(),
                     [](const PlyProperty& p) { return p.count_kind.has_value(); });
}

size_t PlyElement::min_row_bytes() const {
  size_t bytes = 0;
  for (const PlyProperty& property : properties) bytes += BytesOf(property.count_kind.value_or(property.kind));
  return bytes;
}

absl::StatusOr<PlyHeader> ReadPlyHeader(std::string_view bytes) { return HeaderParser(bytes).Parse(); }

std::string_view PlyTypeName(ScalarKind kind) {
  for (const auto& [name, candidate] : kTypes) {
    if (candidate == kind) return name;
  }
  return "";
}

}  // namespace curv
