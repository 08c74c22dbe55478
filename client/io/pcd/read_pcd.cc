#include <lzf.h>

#include <cstdint>
#include <cstring>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "client/io/binary.h"
#include "client/io/formats.h"
#include "client/io/long_integers.h"
#include "client/io/names/column_names.h"
#include "client/io/pcd/packed_colors.h"
#include "client/io/pcd/pcd_header.h"
#include "client/io/text.h"

namespace curv {
namespace {

absl::Status ErrorAt(size_t line, const std::string& problem) {
  return absl::InvalidArgumentError(absl::StrCat("line ", line, ": ", problem));
}

ScalarKind KindOf(const PcdField& field) { return KindOfScalar(field.bytes, field.type == 'F', field.type == 'I'); }

// The name of the field of packed colors; empty if there is none, or if columns of its colors would not be alone.
std::string PackedField(const std::vector<PcdField>& fields) {
  std::string packed;
  for (const PcdField& field : fields) {
    for (const char* color : {"red", "green", "blue", "alpha"}) {
      if (field.name == color) return "";
    }
    if (!IsPackedColor(field)) continue;
    if (!packed.empty()) return "";
    packed = field.name;
  }
  return packed;
}

// The columns that are kept, parallel to the fields; a field without a column is left out.
class PcdBody {
 public:
  explicit PcdBody(const PcdHeader& header)
      : header_(header), points_(header.points), body_(header.body), packed_(PackedField(header.fields)) {
    columns_.reserve(header.fields.size());
    for (const PcdField& field : header.fields) {
      row_bytes_ += field.row_bytes();
      if (!field.kept()) continue;
      // Colors in text may be integers that no float holds, whatever TYPE says.
      const bool is_wide = field.name == packed_ && field.type == 'F' && header.encoding == "ascii";
      columns_.push_back({field.name, MakeValues(is_wide ? ScalarKind::kFloat64 : KindOf(field))});
    }
  }

  absl::StatusOr<PointTable> Read() {
    absl::Status status = NameColumns();
    if (!status.ok()) return status;
    if (header_.encoding == "ascii") {
      status = ReadText();
    } else if (header_.encoding == "binary") {
      status = ReadRows();
    } else if (header_.encoding == "binary_compressed") {
      status = ReadCompressed();
    } else {
      status = ErrorAt(header_.lines, absl::StrCat("DATA is ", Quoted(header_.encoding),
                                                   ": expected ascii, binary or binary_compressed"));
    }
    if (!status.ok()) return status;
    return Finish();
  }

 private:
  absl::Status NameColumns() {
    std::vector<std::string> spellings;
    for (const Column& column : columns_) spellings.push_back(column.name);
    absl::StatusOr<std::vector<std::string>> names = TableNames(spellings, "FIELDS");
    if (!names.ok()) return ErrorAt(header_.lines, std::string(names.status().message()));
    for (size_t i = 0; i < columns_.size(); ++i) columns_[i].name = std::move((*names)[i]);
    return absl::OkStatus();
  }

  PointTable Finish() {
    PointTable table;
    table.viewpoint = header_.viewpoint;
    table.pcd = header_.frame;
    for (Column& column : columns_) Keep(std::move(column), table);
    NoteRounded(rounded_, table.notes);
    if (left_.find_first_not_of(std::string_view(" \t\r\n\0", 5)) != std::string_view::npos) {
      table.notes.push_back(absl::StrCat("left out ", left_.size(), " bytes after the last point"));
    }
    for (const PcdField& field : header_.fields) {
      if (field.kept() || field.name == "_") continue;
      table.notes.push_back(
          absl::StrCat("left out field ", Printable(field.name), ": it has ", field.count, " values a point"));
    }
    return table;
  }

  // Sets a column, or the colors that it packs.
  void Keep(Column column, PointTable& table) const {
    if (column.name != packed_) return table.Set(std::move(column));
    std::vector<Column> colors = UnpackColors(column);
    if (colors.empty()) {
      table.notes.push_back(
          absl::StrCat("left out field ", column.name, ": text does not say which colors its numbers stand for"));
    }
    for (Column& color : colors) table.Set(std::move(color));
  }

  // Appends one field of all points. 64-bit integers, for which tables have no type, become doubles.
  void Append(const PcdField& field, const char* first, size_t stride, Column& column) {
    if (field.type == 'F' || field.bytes < 8) {
      AppendStrided(first, points_, stride, /*swap=*/false, column);
    } else if (!AppendLongIntegers(first, points_, stride, /*swap=*/false, field.type == 'I', column)) {
      rounded_.insert(column.name);
    }
  }

  absl::Status ReadText() {
    std::vector<Column*> targets;
    size_t next_column = 0;
    for (const PcdField& field : header_.fields) {
      Column* column = field.kept() ? &columns_[next_column++] : nullptr;
      targets.insert(targets.end(), field.count, column);
    }
    LineReader lines(body_, header_.lines + 1);
    uint64_t row = 0;
    for (std::string_view line; row < points_ && lines.Next(line);) {
      if (line.find_first_not_of(" \t") == std::string_view::npos) continue;
      if (absl::Status status = AppendRow(line, lines.number(), targets, &rounded_); !status.ok()) return status;
      ++row;
    }
    left_ = lines.rest();
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
      if (field.kept()) Append(field, body_.data() + offset, row_bytes_, columns_[next_column++]);
      offset += field.row_bytes();
    }
    left_ = body_.substr(points_ * row_bytes_);
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
      if (field.kept()) Append(field, at, field.bytes, columns_[next_column++]);
      at += field.row_bytes() * points_;
    }
    left_ = body_.substr(sizeof(sizes) + sizes[0]);
    return absl::OkStatus();
  }

  const PcdHeader& header_;
  uint64_t points_;
  std::string_view body_;
  const std::string packed_;  // the field whose colors become columns; empty if there is none
  size_t row_bytes_ = 0;
  std::vector<Column> columns_;
  std::set<std::string> rounded_;  // names of columns
  std::string_view left_;          // what follows the last point
};

}  // namespace

absl::StatusOr<PointTable> ReadPcd(std::string_view bytes) {
  absl::StatusOr<PcdHeader> header = ReadPcdHeader(bytes);
  if (!header.ok()) return header.status();
  return PcdBody(*header).Read();
}

}  // namespace curv
