#include "client/io/numpy/npy_columns.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/io/binary.h"
#include "client/io/long_integers.h"
#include "client/io/text.h"

namespace curv {
namespace {

ScalarKind KindOf(const NpyField& field) { return KindOfScalar(field.bytes, field.sort == 'f', field.sort == 'i'); }

// Appends one column; its first scalar is at `first`, the others `stride` bytes apart.
void AppendColumn(const char* first, uint64_t count, size_t stride, const NpyField& field, std::string name,
                  std::vector<Column>& columns, std::vector<std::string>& notes) {
  Column column{std::move(name), MakeValues(KindOf(field))};
  if (field.bytes == 8 && field.sort != 'f') {
    if (!AppendLongIntegers(first, count, stride, field.swap, field.sort == 'i', column)) {
      NoteRounded({column.name}, notes);
    }
  } else {
    AppendStrided(first, count, stride, field.swap, column);
  }
  columns.push_back(std::move(column));
}

}  // namespace

std::vector<std::string> ColumnNamesOf(const std::string& name, uint64_t count) {
  if (count == 1) return {name};
  const bool is_position = name == "positions" || name == "position" || name == "points" || name == "xyz";
  const bool is_normal = name == "normals" || name == "normal";
  const std::string prefix = is_position ? "" : is_normal ? "n" : name;
  if (count == 3) return {prefix + "x", prefix + "y", prefix + "z"};
  std::vector<std::string> names;
  for (uint64_t i = 0; i < count; ++i) names.push_back(absl::StrCat(name, "_", i));
  return names;
}

void AppendColumns(std::string_view file, const NpyHeader& header, const std::string& name,
                   std::vector<Column>& columns, std::vector<std::string>& notes) {
  const uint64_t rest = file.size() - header.array_at - header.elements * header.element_bytes;
  if (rest > 0) {
    notes.push_back(
        absl::StrCat("left out ", rest, " bytes that follow the array", name.empty() ? "" : " ", Printable(name)));
  }
  const uint64_t points = header.shape[0], width = header.shape.size() == 2 ? header.shape[1] : 1;
  for (const NpyField& field : header.fields) {
    const std::string field_name = header.structured ? field.name : name;
    if (!field.kept()) {
      // numpy describes padding as fields without a name.
      if (field.sort != 'V') {
        notes.push_back(absl::StrCat("left out ", Printable(field_name),
                                     ": its scalars are neither numbers of 8 to 64 "
                                     "bits nor truth values"));
      }
      continue;
    }
    const uint64_t count = header.structured ? field.scalars : width;
    if (count > kMaxColumns - std::min(kMaxColumns, columns.size())) {
      notes.push_back(absl::StrCat("left out ", Printable(field_name), ": its ", count,
                                   " columns would make more than ", kMaxColumns));
      continue;
    }
    const std::vector<std::string> names = ColumnNamesOf(field_name, count);
    for (uint64_t i = 0; i < count; ++i) {
      const bool by_column = header.fortran_order && !header.structured;
      const size_t place = field.offset + (by_column ? i * points : i) * field.bytes;
      const size_t stride = by_column ? field.bytes : header.element_bytes * (header.structured ? 1 : width);
      AppendColumn(file.data() + header.array_at + place, points, stride, field, names[i], columns, notes);
    }
  }
}

}  // namespace curv
