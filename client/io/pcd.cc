#include <lzf.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "client/io/binary.h"
#include "client/io/formats.h"
#include "client/io/text.h"

namespace curv {
namespace {

struct PcdField {
  std::string name;
  char type = 'F';  // I, U or F
  uint32_t bytes = 4;
  uint32_t count = 1;

  size_t row_bytes() const { return size_t{bytes} * count; }
  bool kept() const { return count == 1 && name != "_"; }
};

struct PcdHeader {
  std::vector<PcdField> fields;
  std::optional<uint64_t> points;
  std::optional<uint64_t> width;
  std::optional<uint64_t> height;
  std::string encoding;
};

absl::Status ErrorAt(size_t line, const std::string& problem) {
  return absl::InvalidArgumentError(absl::StrCat("line ", line, ": ", problem));
}

// Reads "NAME value value ...", one value a field, into a member of the fields.
template <typename T>
absl::Status ReadEach(std::string_view rest, size_t line, const std::string& keyword, T PcdField::*member,
                      std::vector<PcdField>& fields) {
  for (PcdField& field : fields) {
    const std::string_view word = NextField(rest);
    bool good;
    if constexpr (std::is_same_v<T, char>) {
      good = word.size() == 1;
      if (good) field.*member = word[0];
    } else {
      good = ParseNumber(word, field.*member);
    }
    if (!good) return ErrorAt(line, absl::StrCat(keyword, " of field ", field.name, " is ", Quoted(word)));
  }
  if (!NextField(rest).empty()) {
    return ErrorAt(line, absl::StrCat(keyword, " has more values than the ", fields.size(), " FIELDS"));
  }
  return absl::OkStatus();
}

absl::Status ReadCount(std::string_view rest, size_t line, const std::string& keyword, std::optional<uint64_t>& count) {
  const std::string_view word = NextField(rest);
  uint64_t value;
  if (!ParseNumber(word, value)) {
    return ErrorAt(line, absl::StrCat(keyword, " is ", Quoted(word), ": expected an integer of 0 or more"));
  }
  count = value;
  return absl::OkStatus();
}

absl::Status ReadHeaderLine(std::string_view line, size_t number, PcdHeader& header) {
  const std::string keyword(NextField(line));
  if (keyword.empty() || keyword.front() == '#' || keyword == "VERSION" || keyword == "VIEWPOINT") {
    return absl::OkStatus();
  }
  if (keyword == "FIELDS" || keyword == "COLUMNS") {
    header.fields.clear();
    for (std::string_view name; !(name = NextField(line)).empty();) {
      header.fields.emplace_back().name = std::string(name);
    }
    return absl::OkStatus();
  }
  if (keyword == "SIZE") return ReadEach(line, number, keyword, &PcdField::bytes, header.fields);
  if (keyword == "TYPE") return ReadEach(line, number, keyword, &PcdField::type, header.fields);
  if (keyword == "COUNT") return ReadEach(line, number, keyword, &PcdField::count, header.fields);
  if (keyword == "WIDTH") return ReadCount(line, number, keyword, header.width);
  if (keyword == "HEIGHT") return ReadCount(line, number, keyword, header.height);
  if (keyword == "POINTS") return ReadCount(line, number, keyword, header.points);
  if (keyword == "DATA") {
    header.encoding = std::string(NextField(line));
    return absl::OkStatus();
  }
  return ErrorAt(number, absl::StrCat("unknown keyword ", Quoted(keyword), " in the header of a PCD file"));
}

bool IsKnownType(const PcdField& field) {
  if (field.type == 'F') return field.bytes == 4 || field.bytes == 8;
  return (field.type == 'I' || field.type == 'U') &&
         (field.bytes == 1 || field.bytes == 2 || field.bytes == 4 || field.bytes == 8);
}

// Checks what the lines say together, and resolves the number of points.
absl::Status CheckHeader(size_t line, PcdHeader& header) {
  constexpr uint64_t kMaxValues = 65'536;
  if (header.fields.empty()) return ErrorAt(line, "the header names no FIELDS");
  uint64_t values = 0;
  for (const PcdField& field : header.fields) {
    if (!IsKnownType(field)) {
      return ErrorAt(line, absl::StrCat("field ", field.name, " has TYPE ", std::string(1, field.type), ", SIZE ",
                                        field.bytes, ": expected I or U of 1, 2, 4 or 8 bytes, or F of 4 or 8"));
    }
    values += field.count;
  }
  if (values > kMaxValues) {
    return ErrorAt(line, absl::StrCat("a point has ", values, " values: expected at most ", kMaxValues));
  }
  if (!header.points) {
    if (!header.width || !header.height) return ErrorAt(line, "the header has neither POINTS nor WIDTH and HEIGHT");
    if (*header.height != 0 && *header.width > std::numeric_limits<uint64_t>::max() / *header.height) {
      return ErrorAt(line, "WIDTH times HEIGHT is too large");
    }
    header.points = *header.width * *header.height;
  }
  return absl::OkStatus();
}

ScalarKind KindOf(const PcdField& field) {
  if (field.type == 'F') return field.bytes == 4 ? ScalarKind::kFloat32 : ScalarKind::kFloat64;
  const bool is_signed = field.type == 'I';
  switch (field.bytes) {
    case 1:
      return is_signed ? ScalarKind::kInt8 : ScalarKind::kUint8;
    case 2:
      return is_signed ? ScalarKind::kInt16 : ScalarKind::kUint16;
    case 4:
      return is_signed ? ScalarKind::kInt32 : ScalarKind::kUint32;
    default:
      return ScalarKind::kFloat64;  // of the integer's value, see AppendField
  }
}

std::string TableName(const std::string& name) {
  if (name == "normal_x") return "nx";
  if (name == "normal_y") return "ny";
  if (name == "normal_z") return "nz";
  return name;
}

// Appends one field of many points. 64-bit integers, for which tables have no type, become doubles.
void AppendField(const PcdField& field, const char* first, size_t count, size_t stride, Column& column) {
  if (field.type == 'F' || field.bytes < 8) return AppendStrided(first, count, stride, /*swap=*/false, column);
  auto& values = std::get<std::vector<double>>(column.values);
  for (size_t i = 0; i < count; ++i) {
    int64_t integer;
    std::memcpy(&integer, first + i * stride, sizeof(integer));
    values.push_back(field.type == 'I' ? static_cast<double>(integer)
                                       : static_cast<double>(static_cast<uint64_t>(integer)));
  }
}

// The columns that are kept, parallel to the fields; a field without a column is left out.
class PcdBody {
 public:
  PcdBody(const PcdHeader& header, std::string_view body, size_t header_lines)
      : header_(header), points_(*header.points), body_(body), header_lines_(header_lines) {
    columns_.reserve(header.fields.size());
    for (const PcdField& field : header.fields) {
      row_bytes_ += field.row_bytes();
      if (field.kept()) columns_.push_back({TableName(field.name), MakeValues(KindOf(field))});
    }
  }

  absl::StatusOr<PointTable> Read() {
    absl::Status status;
    if (header_.encoding == "ascii") {
      status = ReadText();
    } else if (header_.encoding == "binary") {
      status = ReadRows();
    } else if (header_.encoding == "binary_compressed") {
      status = ReadCompressed();
    } else {
      status = ErrorAt(header_lines_, absl::StrCat("DATA is ", Quoted(header_.encoding),
                                                   ": expected ascii, binary or binary_compressed"));
    }
    if (!status.ok()) return status;
    return Finish();
  }

 private:
  PointTable Finish() {
    PointTable table;
    for (Column& column : columns_) table.Set(std::move(column));
    for (const PcdField& field : header_.fields) {
      if (field.kept() || field.name == "_") continue;
      table.notes.push_back(absl::StrCat("left out field ", field.name, ": it has ", field.count, " values a point"));
    }
    return table;
  }

  absl::Status ReadText() {
    std::vector<Column*> targets;
    size_t next_column = 0;
    for (const PcdField& field : header_.fields) {
      Column* column = field.kept() ? &columns_[next_column++] : nullptr;
      targets.insert(targets.end(), field.count, column);
    }
    LineReader lines(body_, header_lines_ + 1);
    uint64_t row = 0;
    for (std::string_view line; row < points_ && lines.Next(line);) {
      if (line.find_first_not_of(" \t") == std::string_view::npos) continue;
      if (absl::Status status = AppendRow(line, lines.number(), targets); !status.ok()) return status;
      ++row;
    }
    if (row == points_) return absl::OkStatus();
    return ErrorAt(lines.number() + 1, absl::StrCat("the file ends after ", row, " of ", points_, " points"));
  }

  absl::Status ReadRows() {
    if (row_bytes_ != 0 && points_ > body_.size() / row_bytes_) {
      return absl::InvalidArgumentError(absl::StrCat("the file ends too early: POINTS is ", points_, ", ", row_bytes_,
                                                     " bytes each, but only ", body_.size(),
                                                     " bytes follow the header"));
    }
    size_t offset = 0, next_column = 0;
    for (const PcdField& field : header_.fields) {
      if (field.kept()) AppendField(field, body_.data() + offset, points_, row_bytes_, columns_[next_column++]);
      offset += field.row_bytes();
    }
    return absl::OkStatus();
  }

  // Two sizes, then the LZF stream of all values of the first field, all of the second, and so on.
  absl::Status ReadCompressed() {
    uint32_t sizes[2];  // compressed, decompressed
    if (body_.size() < sizeof(sizes)) {
      return absl::InvalidArgumentError("the file ends too early: expected 8 bytes of sizes after the header");
    }
    std::memcpy(sizes, body_.data(), sizeof(sizes));
    const std::string_view compressed = body_.substr(sizeof(sizes)).substr(0, sizes[0]);
    if (compressed.size() < sizes[0]) {
      return absl::InvalidArgumentError(absl::StrCat(
          "the file ends too early: ", sizes[0], " compressed bytes are declared, ", compressed.size(), " are left"));
    }
    if (row_bytes_ != 0 && (points_ > sizes[1] / row_bytes_ || points_ * row_bytes_ != sizes[1])) {
      return absl::InvalidArgumentError(absl::StrCat("POINTS is ", points_, ", ", row_bytes_, " bytes each, but ",
                                                     sizes[1], " decompressed bytes are declared"));
    }
    // LZF's longest back reference makes 264 bytes from 3.
    if (sizes[1] / 88 > sizes[0]) {
      return absl::InvalidArgumentError(
          absl::StrCat(sizes[0], " compressed bytes cannot hold the ", sizes[1], " that are declared"));
    }
    std::string plain(sizes[1], '\0');
    if (!plain.empty() && lzf_decompress(compressed.data(), sizes[0], plain.data(), sizes[1]) != sizes[1]) {
      return absl::InvalidArgumentError("the compressed data is damaged: LZF cannot decompress it");
    }
    const char* at = plain.data();
    size_t next_column = 0;
    for (const PcdField& field : header_.fields) {
      if (field.kept()) AppendField(field, at, points_, field.bytes, columns_[next_column++]);
      at += field.row_bytes() * points_;
    }
    return absl::OkStatus();
  }

  const PcdHeader& header_;
  uint64_t points_;
  std::string_view body_;
  size_t header_lines_;
  size_t row_bytes_ = 0;
  std::vector<Column> columns_;
};

}  // namespace

absl::StatusOr<PointTable> ReadPcd(std::string_view bytes) {
  LineReader lines(bytes);
  PcdHeader header;
  std::string_view line;
  while (header.encoding.empty()) {
    if (!lines.Next(line)) return ErrorAt(lines.number() + 1, "the header of a PCD file does not end: expected DATA");
    if (absl::Status status = ReadHeaderLine(line, lines.number(), header); !status.ok()) return status;
  }
  if (absl::Status status = CheckHeader(lines.number(), header); !status.ok()) return status;
  return PcdBody(header, lines.rest(), lines.number()).Read();
}

}  // namespace curv
