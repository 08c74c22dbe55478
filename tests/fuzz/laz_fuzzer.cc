// Feeds any bytes to what a page is made of that decompresses a LAZ file, before the page does.
#include <cstddef>
#include <cstdint>
#include <set>
#include <string>

#include "client/io/las/las_fields.h"
#include "client/report/laz_report.h"
#include "tests/fuzz/require.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  const absl::StatusOr<curv::LazFile> file = curv::ReadLazFile({reinterpret_cast<const char*>(bytes), size});
  if (!file.ok()) {
    fuzz::Require(absl::IsInvalidArgument(file.status()), "errors are INVALID_ARGUMENT");
    const absl::string_view message = file.status().message();
    fuzz::Require(fuzz::IsShowable({message.data(), message.size()}), "messages are printable");
    return 0;
  }
  const curv::LasHeader& header = file->layout.header;
  fuzz::Require(header.points > 0, "there are points");
  fuzz::Require(header.points <= curv::kMostDecompressedBytes / header.record_bytes, "points have room in a page");
  std::set<std::string> names;
  for (const curv::LasField& field : file->layout.fields) {
    fuzz::Require(field.offset + curv::BytesOf(field.type) <= header.record_bytes, "fields lie in their record");
    fuzz::Require(names.insert(field.name).second, "no two fields have the same name");
  }
  for (const std::string& note : file->layout.notes) fuzz::Require(fuzz::IsShowable(note), "notes are printable");
  fuzz::Require(curv::MakeLazPage(*file, {}).size() > size, "a page holds the file");
  return 0;
}
