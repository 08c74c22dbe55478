#include "client/io/blocks/row_layout.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/io/bytes.h"
#include "client/io/numpy/npy_header.h"
#include "client/io/pcd/pcd_header.h"
#include "client/io/ply_header.h"
#include "client/io/text.h"

namespace curv {
namespace {

// Calls replace(first word, second word) for each line of a header; what it returns stands in the line's place, unless
// it is empty.
template <typename Replace>
std::string WithLines(std::string_view header, const Replace& replace) {
  LineReader lines(header);
  std::string result;
  for (std::string_view line; lines.Next(line);) {
    std::string_view rest = line;
    const std::string_view first = NextField(rest), second = NextField(rest);
    const std::string other = replace(first, second);
    absl::StrAppend(&result, other.empty() ? std::string(line) : other, "\n");
  }
  return result;
}

}  // namespace

std::optional<RowLayout> PlyLayout(std::string_view start) {
  const absl::StatusOr<PlyHeader> header = ReadPlyHeader(start);
  if (!header.ok() || header->format == PlyFormat::kAscii || header->elements.empty()) return std::nullopt;
  const PlyElement& vertex = header->elements.front();
  if (vertex.name != "vertex" || vertex.has_lists() || vertex.min_row_bytes() == 0) return std::nullopt;
  return RowLayout{vertex.count, header->bytes, vertex.min_row_bytes(),
                   [head = std::string(start.substr(0, header->bytes))](uint64_t rows) {
                     return WithLines(head, [rows](std::string_view first, std::string_view second) {
                       const bool counts = first == "element" && second == "vertex";
                       return counts ? absl::StrCat("element vertex ", rows) : std::string();
                     });
                   }};
}

std::optional<RowLayout> PcdLayout(std::string_view start) {
  const absl::StatusOr<PcdHeader> header = ReadPcdHeader(start);
  if (!header.ok() || header->encoding != "binary") return std::nullopt;
  size_t row_bytes = 0;
  for (const PcdField& field : header->fields) row_bytes += field.row_bytes();
  if (row_bytes == 0) return std::nullopt;
  const size_t head_bytes = start.size() - header->body.size();
  return RowLayout{header->points, head_bytes, row_bytes,
                   [head = std::string(start.substr(0, head_bytes))](uint64_t rows) {
                     return WithLines(head, [rows](std::string_view first, std::string_view) -> std::string {
                       if (first == "HEIGHT") return "HEIGHT 1";
                       if (first == "WIDTH" || first == "POINTS") return absl::StrCat(std::string(first), " ", rows);
                       return "";
                     });
                   }};
}

std::optional<RowLayout> NpyLayout(std::string_view start) {
  constexpr std::string_view kShape = "'shape': (";
  // A header is read with the size of its array; here the array is not there.
  const size_t shape_at = start.find(kShape);
  if (shape_at == std::string_view::npos) return std::nullopt;
  const size_t digits_at = shape_at + kShape.size();
  const size_t digits = std::min(start.find_first_not_of("0123456789", digits_at), start.size()) - digits_at;
  uint64_t rows = 0;
  if (!ParseNumber(start.substr(digits_at, digits), rows) || rows == 0) return std::nullopt;
  // As wide as before, since the header tells its own size.
  const auto with_rows = [digits_at, digits](std::string head, uint64_t count) {
    std::string text = absl::StrCat(count);
    text.append(digits - std::min(digits, text.size()), ' ');
    return head.replace(digits_at, digits, text);
  };
  const absl::StatusOr<NpyHeader> empty = ReadNpyHeader(with_rows(std::string(start), 0));
  if (!empty.ok() || (empty->fortran_order && empty->shape.size() > 1)) return std::nullopt;
  uint64_t row_bytes = empty->element_bytes;
  for (size_t i = 1; i < empty->shape.size(); ++i) {
    if (empty->shape[i] == 0 || empty->shape[i] > kLayoutBytes / row_bytes) return std::nullopt;
    row_bytes *= empty->shape[i];
  }
  return RowLayout{
      rows, empty->array_at, row_bytes,
      [head = std::string(start.substr(0, empty->array_at)), with_rows](uint64_t n) { return with_rows(head, n); }};
}

uint64_t LasPointsAt(std::string_view start) { return start.size() < 100 ? 0 : ScalarAt<uint32_t>(start, 96); }

std::optional<RowLayout> LasLayout(std::string_view start) {
  // Bytes of the header that tell how many points there are, and where what follows them is.
  constexpr size_t kFormat = 104, kRecordBytes = 105, kLegacyCount = 107, kWaveforms = 227, kExtended = 235,
                   kExtendedCount = 243, kCount = 247;
  const uint64_t points_at = LasPointsAt(start);
  if (points_at < 227 || points_at > start.size() || start.substr(0, 4) != "LASF") return std::nullopt;
  // Compressed points have no rows.
  if ((ScalarAt<uint8_t>(start, kFormat) & 0xC0) != 0) return std::nullopt;
  const auto minor_version = ScalarAt<uint8_t>(start, 25);
  const size_t row_bytes = ScalarAt<uint16_t>(start, kRecordBytes);
  if (row_bytes == 0 || (minor_version >= 4 && points_at < 375) || (minor_version == 3 && points_at < 235)) {
    return std::nullopt;
  }
  uint64_t rows = ScalarAt<uint32_t>(start, kLegacyCount);
  const bool has_legacy = rows != 0;
  if (minor_version >= 4 && ScalarAt<uint64_t>(start, kCount) != 0) rows = ScalarAt<uint64_t>(start, kCount);
  return RowLayout{rows, points_at, row_bytes,
                   [head = std::string(start.substr(0, points_at)), minor_version, has_legacy](uint64_t n) {
                     std::string patched = head;
                     if (has_legacy || minor_version < 4) PutScalar(static_cast<uint32_t>(n), kLegacyCount, patched);
                     if (minor_version >= 3) PutScalar(uint64_t{0}, kWaveforms, patched);
                     if (minor_version >= 4) {
                       PutScalar(uint64_t{0}, kExtended, patched);
                       PutScalar(uint32_t{0}, kExtendedCount, patched);
                       PutScalar(n, kCount, patched);
                     }
                     return patched;
                   }};
}

}  // namespace curv
