#include <algorithm>
#include <cstddef>
#include <iterator>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "client/io/archive/zip.h"
#include "client/io/formats.h"
#include "client/io/names/column_names.h"
#include "client/io/names/columns_by_place.h"
#include "client/io/numpy/npy_columns.h"
#include "client/io/text.h"

namespace curv {
namespace {

constexpr char kNpyEnding[] = ".npy";

// Puts columns of equal length into a table, each name once.
void SetAll(std::vector<Column> columns, PointTable& table) {
  for (Column& column : columns) {
    column.name = TableName(column.name);
    if (table.Find(column.name) != nullptr) {
      table.notes.push_back(absl::StrCat("left out a second column ", Printable(column.name)));
      continue;
    }
    table.Set(std::move(column));
  }
}

// Columns 4 to 6 are taken for normals unless they cannot be: where a large file is read in parts, one of them may have
// no normals but 0 0 0.
void NameArray(std::vector<Column>& columns, std::vector<std::string>& notes) {
  NameByPlace(NoVectors::kAreNormals, "save them as the array normals of an .npz", columns, notes);
}

// The name of the array in a member; empty if there is none.
std::string ArrayName(const ZipMember& member) {
  const size_t ending = sizeof(kNpyEnding) - 1;
  const bool is_array = member.name.size() > ending && member.name.ends_with(kNpyEnding);
  return is_array ? member.name.substr(0, member.name.size() - ending) : "";
}

bool HoldsPositions(const std::string& name) {
  return name == "positions" || name == "points" || name == "xyz" || TableName(name) == "x";
}

// The member that says how many points there are: that of the positions.
absl::StatusOr<const ZipMember*> FindPositions(const std::vector<ZipMember>& members) {
  std::string names;
  for (const ZipMember& member : members) {
    if (HoldsPositions(ArrayName(member))) return &member;
    if (names.size() < 500) absl::StrAppend(&names, " ", Printable(ArrayName(member)));
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "the archive has no positions: expected an array positions, points or xyz, or x, y and z; it has:", names));
}

// Whether the array of the positions, `what` in messages, can hold them.
absl::Status CheckPositions(const NpyHeader& header, const std::string& what) {
  if (header.structured) return absl::OkStatus();
  // No cloud of so few points has so many further columns.
  constexpr uint64_t kMostBesideFew = 64;
  const std::vector<uint64_t>& shape = header.shape;
  if (shape.size() == 2 && (shape[0] == 3 || shape[0] == 6) && shape[1] > kMostBesideFew) {
    return absl::InvalidArgumentError(absl::StrCat(what, " has the shape ", ShapeText(shape),
                                                   ", that of a transposed one: expected (N, 3), x y z, or (N, 6)"));
  }
  const NpyField& scalars = header.fields[0];
  if (scalars.kept() && scalars.sort != 'b') return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(what, " has the type ", Printable({&scalars.sort, 1}), scalars.bytes,
                                                 ": expected f4, f8, or integers of 1, 2, 4 or 8 bytes"));
}

// Appends the columns of a member, if it has an element for each of `points`.
absl::Status AppendMember(std::string_view file, const ZipMember& member, uint64_t points, std::vector<Column>& columns,
                          std::vector<std::string>& notes) {
  const absl::StatusOr<NpyHeader> header = ReadNpyHeader(file);
  if (!header.ok()) {
    return absl::InvalidArgumentError(
        absl::StrCat("array ", Printable(ArrayName(member)), ": ", header.status().message()));
  }
  const size_t dimensions = header->shape.size();
  if (dimensions < 1 || dimensions > (header->structured ? 1 : 2) || header->shape[0] != points) {
    notes.push_back(absl::StrCat("left out array ", Printable(ArrayName(member)), ": its shape is ",
                                 ShapeText(header->shape), ", there are ", points, " points"));
    return absl::OkStatus();
  }
  const auto before = static_cast<std::ptrdiff_t>(columns.size());
  AppendColumns(file, *header, ArrayName(member), columns, notes);
  if (!HoldsPositions(ArrayName(member)) || header->structured) return absl::OkStatus();
  // Positions with more beside them, as .npy has them.
  std::vector<Column> own(std::move_iterator(columns.begin() + before), std::move_iterator(columns.end()));
  columns.erase(columns.begin() + before, columns.end());
  if (own.size() > 3) NameArray(own, notes);
  std::move(own.begin(), own.end(), std::back_inserter(columns));
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<PointTable> ReadNpy(std::string_view bytes) {
  const absl::StatusOr<NpyHeader> header = ReadNpyHeader(bytes);
  if (!header.ok()) return header.status();
  const std::vector<uint64_t>& shape = header->shape;
  const bool is_matrix = !header->structured && shape.size() == 2 && shape[1] >= 3 && shape[1] <= kMaxColumns;
  if (!is_matrix && !(header->structured && shape.size() == 1)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "the array has the shape ", ShapeText(shape),
        header->structured ? ": a structured one must have (N,)"
                           : ": expected (N, 3), x y z, or (N, 6), with nx ny nz; further columns may follow"));
  }
  if (absl::Status status = CheckPositions(*header, "the array"); !status.ok()) return status;
  PointTable table;
  std::vector<Column> columns;
  AppendColumns(bytes, *header, "", columns, table.notes);
  if (!header->structured) NameArray(columns, table.notes);
  SetAll(std::move(columns), table);
  return table;
}

absl::StatusOr<PointTable> ReadNpz(std::string_view bytes) {
  const absl::StatusOr<std::vector<ZipMember>> members = ReadZipDirectory(bytes);
  if (!members.ok()) return members.status();
  const absl::StatusOr<const ZipMember*> positions = FindPositions(*members);
  if (!positions.ok()) return positions.status();
  const absl::StatusOr<std::string> first = ReadZipMember(bytes, **positions);
  if (!first.ok()) return first.status();
  const absl::StatusOr<NpyHeader> header = ReadNpyHeader(*first);
  if (!header.ok()) return header.status();
  if (header->shape.empty()) return absl::InvalidArgumentError("the positions are one number: expected (N, 3) or (N,)");
  const std::string what = absl::StrCat("the array ", Printable(ArrayName(**positions)));
  if (absl::Status status = CheckPositions(*header, what); !status.ok()) return status;
  PointTable table;
  std::vector<Column> columns;
  for (const ZipMember& member : *members) {
    if (ArrayName(member).empty()) {
      table.notes.push_back(absl::StrCat("left out member ", Printable(member.name), ": it is no array"));
      continue;
    }
    absl::StatusOr<std::string> other = std::string();
    if (&member != *positions) other = ReadZipMember(bytes, member);
    if (!other.ok()) return other.status();
    absl::Status status =
        AppendMember(&member == *positions ? *first : *other, member, header->shape[0], columns, table.notes);
    if (!status.ok()) return status;
  }
  SetAll(std::move(columns), table);
  return table;
}

}  // namespace curv
