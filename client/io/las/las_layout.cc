#include "client/io/las/las_layout.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <set>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "client/io/bytes.h"
#include "client/io/las/extra_bytes.h"

namespace curv {
namespace {

// The fields of a point behind X, Y and Z: those of its format, then the extra ones.
std::vector<LasField> AllFields(const LasFrame& frame, size_t extras_at, const std::vector<LasExtra>& extras) {
  std::vector<LasField> fields = StandardFields(frame.point_format);
  for (const LasExtra& extra : extras) {
    for (LasField& field : FieldsOf(extra, extras_at)) fields.push_back(std::move(field));
    extras_at += BytesOf(extra);
  }
  return fields;
}

std::set<std::string> StandardNames(uint8_t format) {
  std::set<std::string> names = {"x", "y", "z"};
  for (const LasField& field : StandardFields(format)) {
    names.insert(field.name);
    if (field.is_wide()) names.insert({field.name + "_low", field.name + "_high"});
  }
  return names;
}

// Whether the file says that x and y are longitude and latitude: by the GeoTIFF key GTModelType, or the first word of
// the well-known text.
bool IsGeographic(const LasFrame& frame) {
  constexpr uint16_t kGeoKeys = 34735, kWellKnownText = 2112, kModelType = 1024, kGeographic = 2;
  for (const LasRecord& record : frame.records) {
    const std::string_view payload = record.payload;
    if (record.Is("LASF_Projection", kWellKnownText)) {
      const absl::string_view text = absl::StripLeadingAsciiWhitespace({payload.data(), payload.size()});
      for (const char* word : {"GEOGCS", "GEOGCRS", "GEOGRAPHICCRS"}) {
        if (absl::StartsWithIgnoreCase(text, word)) return true;
      }
    } else if (record.Is("LASF_Projection", kGeoKeys)) {
      // Keys of four numbers each, behind a header of four; the last is the value.
      for (size_t at = 8; at + 8 <= payload.size(); at += 8) {
        if (ScalarAt<uint16_t>(payload, at) == kModelType && ScalarAt<uint16_t>(payload, at + 6) == kGeographic) {
          return true;
        }
      }
    }
  }
  return false;
}

void AddNotes(const LasFrame& frame, std::vector<std::string>& notes) {
  if (IsGeographic(frame)) {
    notes.push_back(
        "the file's coordinates are longitude and latitude: curvature needs one length unit on all axes. Project the "
        "points first, as with \"pdal translate in.las out.las reprojection\"");
  }
  for (const LasAxis& axis : frame.axes) {
    constexpr double kFinest = 9'007'199'254'740'992.0;  // 2^53
    if (std::abs(axis.offset) / axis.scale < kFinest) continue;
    notes.push_back(absl::StrCat("coordinates are rounded: an offset of ", axis.offset, " with a scale factor of ",
                                 axis.scale, " takes more digits than a double has"));
    break;
  }
}

}  // namespace

absl::StatusOr<LasLayout> ReadLasLayout(std::string_view file, Decompressor decompressor) {
  absl::StatusOr<LasHeader> header = ReadLasHeader(file, decompressor);
  if (!header.ok()) return header.status();
  LasLayout layout{.header = *std::move(header), .extras = {}, .fields = {}, .notes = {}};
  const LasFrame& frame = layout.header.frame;
  const size_t standard = LasRecordBytes(frame.point_format);
  std::set<std::string> names = StandardNames(frame.point_format);
  layout.extras =
      ReadDescriptors(layout.header.extra_bytes, layout.header.record_bytes - standard, names, layout.notes);
  layout.fields = AllFields(frame, standard, layout.extras);
  AddNotes(frame, layout.notes);
  layout.header.extra_bytes.clear();
  return layout;
}

LasBox BoxOfHeader(std::string_view file) {
  // The largest comes before the smallest, axis by axis.
  constexpr size_t kBoxAt = 179, kAxisBytes = 16;
  LasBox box;
  for (size_t axis = 0; axis < 3; ++axis) {
    box.high[axis] = ScalarAt<double>(file, kBoxAt + axis * kAxisBytes);
    box.low[axis] = ScalarAt<double>(file, kBoxAt + axis * kAxisBytes + sizeof(double));
  }
  return box;
}

}  // namespace curv
