#include "client/io/las/las_header.h"

#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "client/io/bytes.h"
#include "client/io/las/extra_bytes.h"
#include "client/io/las/las_fields.h"
#include "client/io/las/laz_points.h"
#include "client/io/text.h"

namespace curv {
namespace {

template <typename... Parts>
absl::Status Error(const Parts&... parts) {
  return absl::InvalidArgumentError(absl::StrCat(parts...));
}

constexpr size_t kSmallestHeader = 227;
constexpr uint8_t kCompressedBits = 0xC0;
constexpr char kLaszipUser[] = "laszip encoded";
constexpr uint16_t kLaszipId = 22204;

// The most bytes of points that a byte of a compressed file may stand for; surveys have 5 to 20.
constexpr uint64_t kMostInflation = 1024;

// Points are compressed where LASzip has marked their format.
absl::Status CompressedError(std::string_view file) {
  const size_t first_record = ScalarAt<uint16_t>(file, 94);
  const bool is_copc =
      first_record + kLasRecordHeaderBytes <= file.size() && TextOf(file.substr(first_record + 2, 16)) == "copc";
  return Error(
      "the points are compressed (", is_copc ? "COPC, a kind of LAZ" : "LAZ",
      "; byte 104, the point data record format, is ", static_cast<unsigned>(file[104] & 0xff),
      "): this curv was built without lazperf, and reads plain LAS. Decompress the file first, with \"laszip -i in.laz "
      "-o out.las\", \"pdal translate in.laz out.las\" or, of the Node.js client, \"npx curvd-las in.laz "
      "out.las\"; curv report and curv view show it as it is");
}

// Reads the header field by field.
class HeaderReader {
 public:
  HeaderReader(std::string_view file, Decompressor decompressor) : file_(file), decompressor_(decompressor) {}

  absl::StatusOr<LasHeader> Read() {
    for (auto step : {&HeaderReader::ReadStart, &HeaderReader::ReadLayout, &HeaderReader::ReadCount,
                      &HeaderReader::ReadAxes, &HeaderReader::ReadRecords, &HeaderReader::ReadExtendedRecords}) {
      if (absl::Status status = (this->*step)(); !status.ok()) return status;
    }
    TakeExtraBytes();
    if (header_.is_compressed) header_.end = file_.size();
    return std::move(header_);
  }

 private:
  template <typename T>
  T At(size_t at) const {
    return ScalarAt<T>(file_, at);
  }
  LasFrame& frame() { return header_.frame; }

  absl::Status ReadStart() {
    if (file_.substr(0, 4) != "LASF") {
      return Error("the signature of the file is ", Quoted(file_.substr(0, 4)), ": a LAS file starts with \"LASF\"");
    }
    if (file_.size() < kSmallestHeader) {
      return Error("the file ends after ", file_.size(), " bytes: the header of a LAS file has ", kSmallestHeader,
                   " or more");
    }
    const uint8_t major = At<uint8_t>(24);
    frame().minor_version = At<uint8_t>(25);
    if (major != 1 || frame().minor_version > 4) {
      return Error("the version is ", static_cast<unsigned>(major), ".", static_cast<unsigned>(frame().minor_version),
                   ": expected LAS 1.0 to 1.4");
    }
    frame().point_format = At<uint8_t>(104);
    if ((frame().point_format & kCompressedBits) != 0) {
      if (decompressor_ == Decompressor::kThisProgram && !CanReadLaz()) return CompressedError(file_);
      header_.is_compressed = true;
      frame().point_format &= static_cast<uint8_t>(~kCompressedBits);
    }
    if (frame().point_format > kMaxLasFormat) {
      return Error("the point data record format is ", static_cast<unsigned>(frame().point_format), ": expected 0 to ",
                   static_cast<unsigned>(kMaxLasFormat));
    }
    frame().file_source_id = At<uint16_t>(4);
    frame().global_encoding = At<uint16_t>(6);
    frame().project_id = file_.substr(8, 16);
    frame().system_identifier = file_.substr(26, 32);
    frame().creation_day = At<uint16_t>(90);
    frame().creation_year = At<uint16_t>(92);
    return absl::OkStatus();
  }

  absl::Status ReadLayout() {
    const size_t known = LasHeaderBytes(frame().minor_version);
    header_bytes_ = At<uint16_t>(94);
    if (header_bytes_ < known || header_bytes_ > file_.size()) {
      return Error("the header size is ", header_bytes_, ": expected at least ", known, ", for LAS 1.",
                   static_cast<unsigned>(frame().minor_version), ", and at most ", file_.size(),
                   ", the size of the file");
    }
    frame().header_rest = file_.substr(known, header_bytes_ - known);
    header_.points_at = At<uint32_t>(96);
    if (header_.points_at < header_bytes_ || header_.points_at > file_.size()) {
      return Error("the offset to point data is ", header_.points_at, ": expected at least ", header_bytes_,
                   ", the size of the header, and at most ", file_.size(), ", the size of the file");
    }
    header_.record_bytes = At<uint16_t>(105);
    const size_t least = LasRecordBytes(frame().point_format);
    if (header_.record_bytes < least) {
      return Error("the point data record length is ", header_.record_bytes, ": points of format ",
                   static_cast<unsigned>(frame().point_format), " take ", least, " bytes or more");
    }
    return absl::OkStatus();
  }

  // Also bounds what a lying count can make us allocate.
  absl::Status ReadCount() {
    const uint64_t legacy = At<uint32_t>(107);
    uint64_t count = legacy;
    if (frame().minor_version >= 4) {
      count = At<uint64_t>(247);
      if (count == 0) count = legacy;
      if (legacy != 0 && legacy != count) {
        return Error("the legacy number of point records is ", legacy, ", the number of point records ", count,
                     ": expected 0 or the same");
      }
    }
    const size_t room = file_.size() - header_.points_at;
    if (header_.is_compressed) return TakeCompressedCount(count, room);
    if (count > room / header_.record_bytes) {
      return Error("the file ends too early: the number of point records is ", count, ", ", header_.record_bytes,
                   " bytes each, but only ", room, " bytes follow the offset to point data, ", header_.points_at);
    }
    header_.points = count;
    header_.end = header_.points_at + header_.points * header_.record_bytes;
    return absl::OkStatus();
  }

  // Where compressed points end is not said: their chunks and what describes these take the room up to the first
  // extended record, or to the end of the file.
  absl::Status TakeCompressedCount(uint64_t count, size_t room) {
    if (count > room * kMostInflation / header_.record_bytes) {
      return Error("the number of point records is ", count, ", ", header_.record_bytes, " bytes each, but only ", room,
                   " bytes follow the offset to point data, ", header_.points_at, ": each may stand for ",
                   kMostInflation, " bytes of points at most");
    }
    header_.points = count;
    header_.end = header_.points_at;
    return absl::OkStatus();
  }

  absl::Status ReadAxes() {
    for (size_t axis = 0; axis < 3; ++axis) {
      const char name = "XYZ"[axis];
      const LasAxis lattice{.scale = At<double>(131 + 8 * axis), .offset = At<double>(155 + 8 * axis)};
      if (!std::isfinite(lattice.scale) || lattice.scale <= 0.0) {
        return Error("the ", std::string(1, name), " scale factor is ", lattice.scale,
                     ": expected a finite number above 0");
      }
      if (!std::isfinite(lattice.offset)) {
        return Error("the ", std::string(1, name), " offset is ", lattice.offset, ": expected a finite number");
      }
      for (const int32_t raw : {std::numeric_limits<int32_t>::min(), std::numeric_limits<int32_t>::max()}) {
        if (std::isfinite(lattice.At(raw))) continue;
        return Error("the ", std::string(1, name), " scale factor is ", lattice.scale, ", the offset ", lattice.offset,
                     ": coordinates would leave the range of double");
      }
      frame().axes[axis] = lattice;
    }
    return absl::OkStatus();
  }

  absl::Status ReadRecords() {
    const uint32_t count = At<uint32_t>(100);
    const size_t room = header_.points_at - header_bytes_;
    if (count > room / kLasRecordHeaderBytes) {
      return Error("the number of variable length records is ", count, ", ", kLasRecordHeaderBytes,
                   " bytes or more each, but only ", room, " bytes are left before the points");
    }
    size_t at = header_bytes_;
    for (uint32_t i = 0; i < count; ++i) {
      if (absl::Status status = ReadRecord(i, false, header_.points_at, at); !status.ok()) return status;
    }
    return absl::OkStatus();
  }

  absl::Status ReadExtendedRecords() {
    const uint64_t waveforms = frame().minor_version >= 3 ? At<uint64_t>(227) : 0;
    // In LAS 1.3, waveform packets within the file are the one extended record that there can be.
    constexpr uint16_t kWaveformsInside = 2;
    uint64_t start = 0;
    uint32_t count = 0;
    if (frame().minor_version >= 4) {
      start = At<uint64_t>(235);
      count = At<uint32_t>(243);
    } else if (waveforms != 0 && (frame().global_encoding & kWaveformsInside) != 0) {
      start = waveforms;
      count = 1;
    }
    if (count == 0) return absl::OkStatus();
    if (start < header_.end || start > file_.size()) {
      return Error("the start of the first extended variable length record is ", start, ": expected at least ",
                   header_.end, ", where the points end, and at most ", file_.size(), ", the size of the file");
    }
    size_t at = start;
    if (count > (file_.size() - at) / kLasExtendedRecordHeaderBytes) {
      return Error("the number of extended variable length records is ", count, ", ", kLasExtendedRecordHeaderBytes,
                   " bytes or more each, but only ", file_.size() - at, " bytes follow their start, ", at);
    }
    for (uint32_t i = 0; i < count; ++i) {
      if (at == waveforms) frame().waveform_record = frame().records.size();
      if (absl::Status status = ReadRecord(i, true, file_.size(), at); !status.ok()) return status;
    }
    header_.end = at;
    return absl::OkStatus();
  }

  // Reads record `index` at byte `at`, and moves `at` behind it. `limit` is the byte where records must have ended.
  absl::Status ReadRecord(uint32_t index, bool extended, size_t limit, size_t& at) {
    const char* const kind = extended ? "extended variable length record " : "variable length record ";
    const size_t head = extended ? kLasExtendedRecordHeaderBytes : kLasRecordHeaderBytes;
    if (limit - at < head) {
      return Error(kind, index, " starts at byte ", at, ": its header has ", head, " bytes, ", limit - at, " are left");
    }
    LasRecord record{.user_id = std::string(file_.substr(at + 2, 16)),
                     .id = At<uint16_t>(at + 18),
                     .description = {},
                     .payload = {},
                     .extended = extended};
    const uint64_t bytes = extended ? At<uint64_t>(at + 20) : At<uint16_t>(at + 20);
    record.description = file_.substr(at + (extended ? 28 : 22), 32);
    at += head;
    if (bytes > limit - at) {
      return Error(kind, index, " (", Printable(TextOf(record.user_id)), " ", record.id,
                   ") has the record length after header ", bytes, ": only ", limit - at, " bytes are left before ",
                   extended ? "the end of the file" : "the points");
    }
    record.payload = file_.substr(at, bytes);
    at += bytes;
    frame().records.push_back(std::move(record));
    return absl::OkStatus();
  }

  // Whether a record tells how the points of this file are compressed, which no longer holds for those of another.
  static bool TellsOfCompression(const LasRecord& record) {
    constexpr uint16_t kCopcInfo = 1, kCopcHierarchy = 1000;
    return record.Is(kLaszipUser, kLaszipId) || record.Is("copc", kCopcInfo) || record.Is("copc", kCopcHierarchy);
  }

  // Moves the descriptors of extra bytes out of the records, and drops what tells of compression.
  void TakeExtraBytes() {
    std::vector<LasRecord> kept;
    for (size_t i = 0; i < frame().records.size(); ++i) {
      LasRecord& record = frame().records[i];
      if (record.Is(kLasSpecUser, kLasExtraBytesId) && record.payload.size() % kLasDescriptorBytes == 0) {
        header_.extra_bytes += record.payload;
        continue;
      }
      if (header_.is_compressed && TellsOfCompression(record)) {
        constexpr size_t kChunkPointsAt = 12;
        const bool has_chunks = record.Is(kLaszipUser, kLaszipId) && record.payload.size() >= kChunkPointsAt + 4;
        if (has_chunks) header_.chunk_points = ScalarAt<uint32_t>(record.payload, kChunkPointsAt);
        continue;
      }
      if (frame().waveform_record == i) frame().waveform_record = kept.size();
      kept.push_back(std::move(record));
    }
    frame().records = std::move(kept);
  }

  std::string_view file_;
  Decompressor decompressor_;
  size_t header_bytes_ = 0;
  LasHeader header_;
};

}  // namespace

bool LasRecord::Is(std::string_view user, uint16_t record_id) const {
  return id == record_id && TextOf(user_id) == user;
}

size_t LasHeaderBytes(uint8_t minor_version) {
  if (minor_version >= 4) return 375;
  return minor_version == 3 ? 235 : kSmallestHeader;
}

absl::StatusOr<LasHeader> ReadLasHeader(std::string_view file, Decompressor decompressor) {
  return HeaderReader(file, decompressor).Read();
}

bool IsCompressedLas(std::string_view file) {
  return file.size() >= kSmallestHeader && file.substr(0, 4) == "LASF" && (file[104] & kCompressedBits) != 0;
}

}  // namespace curv
