#include "client/io/archive/zip.h"

#include <zlib.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/io/archive/inflate.h"
#include "client/io/bytes.h"
#include "client/io/point_table.h"
#include "client/io/text.h"

namespace curv {
namespace {

constexpr std::string_view kLocalSignature("PK\x03\x04", 4), kEntrySignature("PK\x01\x02", 4),
    kEndSignature("PK\x05\x06", 4), kEnd64Signature("PK\x06\x06", 4), kLocator64Signature("PK\x06\x07", 4);
constexpr size_t kLocalBytes = 30, kEntryBytes = 46, kEndBytes = 22, kEnd64Bytes = 56, kLocator64Bytes = 20;
constexpr uint16_t kStored = 0, kDeflated = 8, kEncryptedFlag = 1, kNamesAreUtf8 = 1 << 11, kWideId = 1;
// What fields of 32 bits hold whose value stands elsewhere, in 64.
constexpr uint32_t kElsewhere = 0xffffffff;
constexpr uint16_t kVersion = 20, kVersion64 = 45;
constexpr uint16_t kNoDate = 33;  // 1 January 1980, the first

absl::Status Error(const std::string& problem) { return absl::InvalidArgumentError(problem); }

struct Directory {
  uint64_t entries = 0;
  uint64_t at = 0;
};

// Finds where the directory starts: from the end of the archive, behind which there can be a comment.
absl::StatusOr<Directory> FindDirectory(std::string_view archive) {
  constexpr size_t kMaxComment = 65535;
  const size_t begin = archive.size() - std::min(archive.size(), kEndBytes + kMaxComment);
  const size_t found = archive.substr(begin).rfind(kEndSignature);
  if (found == std::string_view::npos || archive.size() - begin - found < kEndBytes) {
    return Error("the archive has no directory at its end: it is no zip, or cut off");
  }
  const size_t end = begin + found;
  Directory directory{ScalarAt<uint16_t>(archive, end + 10), ScalarAt<uint32_t>(archive, end + 16)};
  if (end >= kLocator64Bytes && archive.substr(end - kLocator64Bytes, 4) == kLocator64Signature) {
    const uint64_t at = ScalarAt<uint64_t>(archive, end - kLocator64Bytes + 8);
    if (at > archive.size() || archive.size() - at < kEnd64Bytes || archive.substr(at, 4) != kEnd64Signature) {
      return Error(absl::StrCat("the archive's directory of 64 bits is not at byte ", at));
    }
    directory = {ScalarAt<uint64_t>(archive, at + 32), ScalarAt<uint64_t>(archive, at + 48)};
  }
  if (directory.at > archive.size() || directory.entries > (archive.size() - directory.at) / kEntryBytes) {
    return Error(absl::StrCat("the archive's directory has ", directory.entries, " entries from byte ", directory.at,
                              ": the file has ", archive.size(), " bytes"));
  }
  if (directory.entries > kMaxColumns) {
    return Error(absl::StrCat("the archive has ", directory.entries, " members: expected at most ", kMaxColumns));
  }
  return directory;
}

// Takes sizes and place of a member from its extra field where 32 bits do not hold them.
bool TakeWide(std::string_view extra, ZipMember& member) {
  uint64_t* const wide[] = {&member.bytes, &member.packed_bytes, &member.at};
  if (std::none_of(std::begin(wide), std::end(wide), [](const uint64_t* value) { return *value == kElsewhere; })) {
    return true;
  }
  while (extra.size() >= 4) {
    const auto id = ScalarAt<uint16_t>(extra, 0), bytes = ScalarAt<uint16_t>(extra, 2);
    extra.remove_prefix(4);
    if (bytes > extra.size()) return false;
    if (id == kWideId) {
      std::string_view values = extra.substr(0, bytes);
      for (uint64_t* value : wide) {
        if (*value != kElsewhere) continue;
        if (values.size() < sizeof(uint64_t)) return false;
        *value = ScalarAt<uint64_t>(values, 0);
        values.remove_prefix(sizeof(uint64_t));
      }
      return true;
    }
    extra.remove_prefix(bytes);
  }
  return false;
}

std::string WideExtra(uint64_t bytes, std::optional<uint64_t> at) {
  std::string extra;
  AppendScalar(kWideId, extra);
  AppendScalar<uint16_t>(at.has_value() ? 24 : 16, extra);
  AppendScalar(bytes, extra);
  AppendScalar(bytes, extra);
  if (at.has_value()) AppendScalar(*at, extra);
  return extra;
}

uint32_t Narrow(uint64_t value, bool wide) { return wide ? kElsewhere : static_cast<uint32_t>(value); }

// What local headers and directory entries share.
std::string Middle(const ZipMember& member, bool wide, size_t extra_bytes) {
  std::string bytes;
  AppendScalar(wide ? kVersion64 : kVersion, bytes);
  AppendScalar(kNamesAreUtf8, bytes);
  AppendScalar(kStored, bytes);
  AppendScalar<uint16_t>(0, bytes);
  AppendScalar(kNoDate, bytes);
  AppendScalar(member.crc, bytes);
  AppendScalar(Narrow(member.bytes, wide), bytes);
  AppendScalar(Narrow(member.bytes, wide), bytes);
  AppendScalar(static_cast<uint16_t>(member.name.size()), bytes);
  AppendScalar(static_cast<uint16_t>(extra_bytes), bytes);
  return bytes;
}

}  // namespace

absl::StatusOr<std::vector<ZipMember>> ReadZipDirectory(std::string_view archive) {
  const absl::StatusOr<Directory> directory = FindDirectory(archive);
  if (!directory.ok()) return directory.status();
  std::vector<ZipMember> members;
  uint64_t at = directory->at, packed = 0;
  for (uint64_t i = 0; i < directory->entries; ++i) {
    const auto bad = [i, at](const char* what) {
      return Error(absl::StrCat("entry ", i, " of the archive's directory, at byte ", at, ", ", what));
    };
    if (archive.size() - at < kEntryBytes || archive.substr(at, 4) != kEntrySignature) return bad("is none");
    const size_t name = ScalarAt<uint16_t>(archive, at + 28), extra = ScalarAt<uint16_t>(archive, at + 30);
    const size_t comment = ScalarAt<uint16_t>(archive, at + 32);
    if (archive.size() - at - kEntryBytes < name + extra + comment) return bad("reaches beyond the file");
    if ((ScalarAt<uint16_t>(archive, at + 8) & kEncryptedFlag) != 0) return bad("is encrypted");
    ZipMember member{.name = std::string(archive.substr(at + kEntryBytes, name)),
                     .method = ScalarAt<uint16_t>(archive, at + 10),
                     .crc = ScalarAt<uint32_t>(archive, at + 16),
                     .packed_bytes = ScalarAt<uint32_t>(archive, at + 20),
                     .bytes = ScalarAt<uint32_t>(archive, at + 24),
                     .at = ScalarAt<uint32_t>(archive, at + 42)};
    if (!TakeWide(archive.substr(at + kEntryBytes + name, extra), member)) return bad("lacks its size of 64 bits");
    // Members that share bytes could take any amount of memory.
    if (member.packed_bytes > archive.size() - packed) return bad("and those before it are larger than the archive");
    packed += member.packed_bytes;
    at += kEntryBytes + name + extra + comment;
    members.push_back(std::move(member));
  }
  return members;
}

absl::StatusOr<std::string> ReadZipMember(std::string_view archive, const ZipMember& member) {
  const auto bad = [&member](const std::string& what) {
    return Error(absl::StrCat("member ", Printable(member.name), " of the archive ", what));
  };
  if (member.at > archive.size() || archive.size() - member.at < kLocalBytes ||
      archive.substr(member.at, 4) != kLocalSignature) {
    return bad(absl::StrCat("does not start at byte ", member.at));
  }
  const size_t head =
      kLocalBytes + ScalarAt<uint16_t>(archive, member.at + 26) + ScalarAt<uint16_t>(archive, member.at + 28);
  if (archive.size() - member.at < head || archive.size() - member.at - head < member.packed_bytes) {
    return bad(absl::StrCat("has ", member.packed_bytes, " bytes: more than are left in the file"));
  }
  const std::string_view packed = archive.substr(member.at + head, member.packed_bytes);
  std::string bytes;
  if (member.method == kStored) {
    if (member.bytes != packed.size()) return bad("has two sizes, though it is stored");
    bytes = packed;
  } else if (member.method == kDeflated) {
    absl::StatusOr<std::string> inflated = InflateRaw(packed, member.bytes);
    if (!inflated.ok()) return bad(std::string(inflated.status().message()));
    bytes = *std::move(inflated);
  } else {
    return bad(absl::StrCat("is packed by method ", member.method, ": expected 0 (stored) or 8 (deflated)"));
  }
  if (Crc32(0, bytes) != member.crc) return bad("is damaged: its CRC-32 is another");
  return bytes;
}

absl::Status ZipWriter::Begin(const std::string& name, uint64_t bytes, uint32_t crc) {
  const ZipMember member{.name = name, .crc = crc, .packed_bytes = bytes, .bytes = bytes, .at = at_};
  const bool wide = bytes >= kElsewhere;
  const std::string extra = wide ? WideExtra(bytes, std::nullopt) : "";
  members_.push_back(member);
  return Append(absl::StrCat(std::string(kLocalSignature), Middle(member, wide, extra.size()), name, extra));
}

absl::Status ZipWriter::Append(std::string_view bytes) {
  at_ += bytes.size();
  return file_.Append(bytes);
}

absl::Status ZipWriter::End() {
  const uint64_t directory_at = at_;
  std::string directory;
  for (const ZipMember& member : members_) {
    const bool wide = member.bytes >= kElsewhere || member.at >= kElsewhere;
    const std::string extra = wide ? WideExtra(member.bytes, member.at) : "";
    directory += kEntrySignature;
    AppendScalar(wide ? kVersion64 : kVersion, directory);
    directory += Middle(member, wide, extra.size());
    directory.append(2 + 2 + 2 + 4, '\0');  // comment, disk, attributes
    AppendScalar(Narrow(member.at, wide), directory);
    directory += member.name + extra;
  }
  const uint64_t end = directory_at + directory.size(), count = members_.size();
  const bool wide = end >= kElsewhere || count >= 0xffff;
  if (wide) {
    directory += kEnd64Signature;
    AppendScalar<uint64_t>(kEnd64Bytes - 12, directory);
    AppendScalar(kVersion64, directory);
    AppendScalar(kVersion64, directory);
    directory.append(8, '\0');  // disks
    for (const uint64_t value : {count, count, end - directory_at, directory_at}) AppendScalar(value, directory);
    directory += kLocator64Signature;
    AppendScalar<uint32_t>(0, directory);
    AppendScalar(end, directory);
    AppendScalar<uint32_t>(1, directory);
  }
  directory += kEndSignature;
  AppendScalar<uint32_t>(0, directory);  // disks
  for (int i = 0; i < 2; ++i) AppendScalar(static_cast<uint16_t>(wide ? 0xffff : count), directory);
  AppendScalar(Narrow(end - directory_at, wide), directory);
  AppendScalar(Narrow(directory_at, wide), directory);
  AppendScalar<uint16_t>(0, directory);
  return Append(directory);
}

uint32_t Crc32(uint32_t crc, std::string_view bytes) {
  return static_cast<uint32_t>(crc32_z(crc, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

}  // namespace curv
