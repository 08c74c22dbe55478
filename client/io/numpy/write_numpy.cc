#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/io/archive/zip.h"
#include "client/io/bytes.h"
#include "client/io/names/column_names.h"
#include "client/io/text.h"
#include "client/io/writers.h"
#include "client/io/writing/rows.h"

namespace curv {
namespace {

// In the order of ScalarKind.
constexpr const char* kTypes[] = {"|i1", "|u1", "<i2", "<u2", "<i4", "<u4", "<f4", "<f8"};

std::string TypeOf(const Column& column) { return absl::StrCat("'", kTypes[static_cast<size_t>(column.kind())], "'"); }

// Whether it is UTF-8, as far as a name must be for numpy to read the header: no cut, overlong or stray bytes.
bool IsUtf8(std::string_view text) {
  while (!text.empty()) {
    const size_t length = LengthOfCharacter(text);
    if (length == 0) return false;
    text.remove_prefix(length);
  }
  return true;
}

bool IsAscii(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x80; });
}

// A name that stands in a header and an archive as it is: without control characters, quotes, backslashes and slashes,
// in UTF-8.
std::string NumpyName(std::string_view column) {
  std::string name(column);
  const bool is_utf8 = IsUtf8(name);
  for (char& c : name) {
    const auto byte = static_cast<unsigned char>(c);
    const bool is_plain = byte >= ' ' && byte != 0x7f && (is_utf8 || byte < 0x80);
    if (!is_plain || c == '\'' || c == '"' || c == '\\' || c == '/') c = '_';
  }
  return name;
}

// The start of an array: version 1.0, 2.0 where the text is long, 3.0 where it is not all ASCII. Its size is a multiple
// of 64, as numpy likes it.
std::string NpyHeaderOf(const std::string& type, size_t count) {
  std::string text = absl::StrCat("{'descr': ", type, ", 'fortran_order': False, 'shape': (", count, ",), }");
  const bool is_ascii = IsAscii(text), is_long = !is_ascii || text.size() > 65'000;
  const size_t head = is_long ? 12 : 10;
  text.append(63 - (head + text.size()) % 64, ' ');
  text += '\n';
  std::string header("\x93NUMPY", 6);
  header += static_cast<char>(!is_ascii ? 3 : is_long ? 2 : 1);
  header += '\0';
  if (is_long) {
    AppendScalar(static_cast<uint32_t>(text.size()), header);
  } else {
    AppendScalar(static_cast<uint16_t>(text.size()), header);
  }
  return header + text;
}

std::string_view BytesOfValues(const Column& column) {
  return std::visit(
      [](const auto& values) {
        return std::string_view(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(values[0]));
      },
      column.values);
}

}  // namespace

std::string NpyHead(const PointTable& like, uint64_t rows) {
  const std::vector<std::string> names = HeaderNames(like, NumpyName);
  std::string type = "[";
  for (size_t i = 0; i < names.size(); ++i) {
    absl::StrAppend(&type, i == 0 ? "" : ", ", "('", names[i], "', ", TypeOf(like.columns()[i]), ")");
  }
  return NpyHeaderOf(type + "]", rows);
}

absl::Status WriteNpy(const PointTable& table, ByteSink& file) {
  if (absl::Status status = file.Append(NpyHead(table, table.size())); !status.ok()) return status;
  return AppendBinaryRows(table, file);
}

absl::Status WriteNpz(const PointTable& table, ByteSink& file) {
  const std::vector<std::string> names = HeaderNames(table, NumpyName);
  ZipWriter archive(file);
  for (size_t i = 0; i < names.size(); ++i) {
    const Column& column = table.columns()[i];
    const std::string header = NpyHeaderOf(TypeOf(column), table.size());
    const std::string_view values = BytesOfValues(column);
    const uint32_t crc = Crc32(Crc32(0, header), values);
    absl::Status status = archive.Begin(names[i] + ".npy", header.size() + values.size(), crc);
    if (status.ok()) status = archive.Append(header);
    if (status.ok()) status = archive.Append(values);
    if (!status.ok()) return status;
  }
  return archive.End();
}

}  // namespace curv
