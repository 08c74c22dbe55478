#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "client/io/binary.h"
#include "client/io/formats.h"
#include "client/io/names/column_names.h"
#include "client/io/ply_header.h"
#include "client/io/point_status.h"
#include "client/io/text.h"

namespace curv {
namespace {

// Reads the elements after a header, and keeps the vertices.
class PlyBody {
 public:
  PlyBody(std::string_view bytes, const PlyHeader& header)
      : header_(header), bytes_(bytes), at_(header.bytes), lines_(bytes.substr(header.bytes), header.lines + 1) {}

  // Reads elements up to the vertices; what follows them is not looked at.
  absl::StatusOr<PointTable> Read() {
    for (const PlyElement& element : header_.elements) {
      const bool is_vertex = element.name == "vertex";
      if (is_vertex && element.count > 0 && element.properties.empty()) {
        return absl::InvalidArgumentError(
            absl::StrCat("the header declares ", element.count, " vertices without a property"));
      }
      absl::Status status = is_vertex ? MakeColumns(element) : absl::OkStatus();
      if (!status.ok()) return status;
      status = header_.format == PlyFormat::kAscii ? ReadText(element, is_vertex)
               : element.has_lists()               ? ReadRowByRow(element, is_vertex)
                                                   : ReadBlock(element, is_vertex);
      if (!status.ok()) return status;
      if (is_vertex) return Finish();
    }
    return absl::InvalidArgumentError("the header declares no element vertex: the file holds no points");
  }

 private:
  absl::Status MakeColumns(const PlyElement& vertex) {
    columns_.reserve(vertex.properties.size());
    std::vector<std::string> spellings;
    for (const PlyProperty& property : vertex.properties) {
      if (property.count_kind) {
        table_.notes.push_back(
            absl::StrCat("left out property ", Printable(property.name), " of the vertices: it is a list"));
      } else {
        columns_.push_back({property.name, MakeValues(property.kind)});
        spellings.push_back(property.name);
      }
    }
    absl::StatusOr<std::vector<std::string>> names = TableNames(spellings, "properties");
    if (!names.ok()) {
      return absl::InvalidArgumentError(absl::StrCat("line ", header_.lines, ": ", names.status().message()));
    }
    for (size_t i = 0; i < columns_.size(); ++i) columns_[i].name = std::move((*names)[i]);
    return absl::OkStatus();
  }

  PointTable Finish() {
    TakeScalarPrefixes();
    for (Column& column : columns_) table_.Set(std::move(column));
    const std::string_view left = header_.format == PlyFormat::kAscii ? lines_.rest() : bytes_.substr(at_);
    if (header_.elements.back().name == "vertex" && left.find_first_not_of(" \t\r\n") != std::string_view::npos) {
      table_.notes.push_back(absl::StrCat("left out ", left.size(), " bytes after the last vertex"));
    }
    for (const PlyElement& element : header_.elements) {
      if (element.name == "vertex" || element.count == 0) continue;
      table_.notes.push_back(absl::StrCat("left out element ", Printable(element.name), " (", element.count, ")"));
    }
    return std::move(table_);
  }

  // CloudCompare has scalar_NAME for NAME, and floats alone: a status is a byte again.
  void TakeScalarPrefixes() {
    std::set<std::string_view> names;
    for (const Column& column : columns_) names.insert(column.name);
    for (Column& column : columns_) {
      const std::string_view name = column.name;
      if (name.substr(0, kScalarPrefix.size()) != kScalarPrefix || name == kScalarPrefix) continue;
      const std::string own = TableName(name.substr(kScalarPrefix.size()));
      if (names.contains(own)) continue;
      names.erase(name);
      column.name = own;
      names.insert(column.name);
      if (IsStatusName(own)) TakeBytes(column);
    }
  }

  static void TakeBytes(Column& column) {
    std::vector<uint8_t> bytes;
    bytes.reserve(column.size());
    for (size_t i = 0; i < column.size(); ++i) {
      const double value = column.At(i);
      if (!(value >= 0.0 && value <= 255.0) || value != std::floor(value)) return;
      bytes.push_back(static_cast<uint8_t>(value));
    }
    column.values = std::move(bytes);
  }

  // Also bounds what a lying count can make us allocate.
  absl::Status CheckRoom(const PlyElement& element, size_t min_row_bytes) const {
    const size_t room = bytes_.size() - at_;
    if (min_row_bytes == 0 || element.count <= room / min_row_bytes) return absl::OkStatus();
    return absl::InvalidArgumentError(absl::StrCat("byte ", at_, ": the file ends too early: ", element.count, " ",
                                                   Printable(element.name), " rows of ", min_row_bytes,
                                                   " bytes or more are declared, ", room, " bytes are left"));
  }

  absl::Status ReadBlock(const PlyElement& element, bool is_vertex) {
    const size_t row_bytes = element.min_row_bytes();
    if (absl::Status status = CheckRoom(element, row_bytes); !status.ok()) return status;
    if (is_vertex) {
      std::vector<RowField> fields;
      size_t offset = 0;
      for (Column& column : columns_) {
        fields.push_back({offset, &column});
        offset += BytesOf(column.kind());
      }
      AppendRows(bytes_.substr(at_), element.count, row_bytes, fields, swap());
    }
    at_ += element.count * row_bytes;
    return absl::OkStatus();
  }

  absl::Status ReadRowByRow(const PlyElement& element, bool is_vertex) {
    if (absl::Status status = CheckRoom(element, element.min_row_bytes()); !status.ok()) return status;
    for (uint64_t row = 0; row < element.count; ++row) {
      size_t next_column = 0;
      for (const PlyProperty& property : element.properties) {
        uint64_t bytes = BytesOf(property.kind);
        if (property.count_kind) {
          Column length{property.name, MakeValues(*property.count_kind)};
          if (!Take(BytesOf(*property.count_kind), &length)) return EndedEarly(element, row);
          const double items = length.At(0);
          if (items < 0) {
            return absl::InvalidArgumentError(absl::StrCat("byte ", at_, ": list ", Printable(property.name), " of ",
                                                           Printable(element.name), " ", row, " has length ", items,
                                                           ": expected 0 or more"));
          }
          bytes *= static_cast<uint64_t>(items);
        }
        Column* column = is_vertex && !property.count_kind ? &columns_[next_column++] : nullptr;
        if (!Take(bytes, column)) return EndedEarly(element, row);
      }
    }
    return absl::OkStatus();
  }

  // Moves over `bytes`, appending them to `column` if there is one. False at the end of the file.
  bool Take(uint64_t bytes, Column* column) {
    if (bytes > bytes_.size() - at_) return false;
    if (column != nullptr) AppendStrided(bytes_.data() + at_, 1, 0, swap(), *column);
    at_ += bytes;
    return true;
  }

  absl::Status EndedEarly(const PlyElement& element, uint64_t row) const {
    return absl::InvalidArgumentError(absl::StrCat("byte ", at_, ": the file ends within ", Printable(element.name),
                                                   " ", row, " of ", element.count));
  }

  absl::Status ReadText(const PlyElement& element, bool is_vertex) {
    if (element.properties.empty()) return absl::OkStatus();
    // A row takes at least a digit for each property and a line end, of which the last may be missing.
    const size_t room = lines_.rest().size() + 1;
    if (element.count > room / (2 * element.properties.size())) {
      return absl::InvalidArgumentError(
          absl::StrCat("line ", lines_.number() + 1, ": the file ends too early: ", element.count, " ",
                       Printable(element.name), " lines are declared, but only ", room - 1, " bytes are left"));
    }
    std::vector<Column*> columns;
    for (Column& column : columns_) columns.push_back(&column);
    for (uint64_t row = 0; row < element.count;) {
      std::string_view line;
      if (!lines_.Next(line)) {
        return absl::InvalidArgumentError(absl::StrCat("line ", lines_.number() + 1, ": the file ends after ", row,
                                                       " of ", element.count, " ", Printable(element.name), " lines"));
      }
      if (line.find_first_not_of(" \t") == std::string_view::npos) continue;
      ++row;
      if (!is_vertex) continue;
      absl::Status status =
          element.has_lists() ? ReadListLine(element, line) : AppendRow(line, lines_.number(), columns);
      if (!status.ok()) return status;
    }
    return absl::OkStatus();
  }

  // Takes the scalars of a line with lists in it.
  absl::Status ReadListLine(const PlyElement& element, std::string_view line) {
    std::string scalars;
    std::vector<Column*> columns;
    size_t next_column = 0;
    for (const PlyProperty& property : element.properties) {
      std::string_view field = NextField(line);
      if (!property.count_kind) {
        scalars.append(field).push_back(' ');
        columns.push_back(&columns_[next_column++]);
        continue;
      }
      uint32_t items = 0;
      if (!ParseNumber(field, items)) {
        return absl::InvalidArgumentError(absl::StrCat("line ", lines_.number(), ": list ", Printable(property.name),
                                                       " has length ", Quoted(field), ": expected an integer"));
      }
      while (items > 0 && !NextField(line).empty()) --items;
      if (items > 0) {
        return absl::InvalidArgumentError(absl::StrCat("line ", lines_.number(), ": list ", Printable(property.name),
                                                       " lacks ", items, " of its values"));
      }
    }
    scalars.append(line);
    return AppendRow(scalars, lines_.number(), columns);
  }

  bool swap() const { return header_.format == PlyFormat::kBigEndian; }

  const PlyHeader& header_;
  std::string_view bytes_;
  size_t at_;         // in binary files, the next byte
  LineReader lines_;  // in ascii files
  std::vector<Column> columns_;
  PointTable table_;
};

}  // namespace

absl::StatusOr<PointTable> ReadPly(std::string_view bytes) {
  absl::StatusOr<PlyHeader> header = ReadPlyHeader(bytes);
  if (!header.ok()) return header.status();
  return PlyBody(bytes, *header).Read();
}

}  // namespace curv
