#include "client/io/las/laz_points.h"

#include "absl/strings/str_cat.h"
#include "client/io/bytes.h"

#ifdef CURV_HAS_LAZPERF
#include <exception>
#include <lazperf/readers.hpp>
#include <new>

#include "client/io/las/las_frame.h"
#endif

namespace curv {

absl::Status CheckChunkTable(std::string_view file, uint64_t points, uint32_t chunk_points) {
  constexpr size_t kTableHead = 8;
  constexpr uint32_t kAnySize = 0xFFFFFFFF;
  const auto points_at = ScalarAt<uint32_t>(file, 96);
  const auto table_at = file.size() < points_at + sizeof(int64_t) ? int64_t{-1} : ScalarAt<int64_t>(file, points_at);
  if (table_at < points_at || static_cast<uint64_t>(table_at) > file.size() - kTableHead) {
    return absl::InvalidArgumentError(absl::StrCat("the table of compressed chunks is at byte ", table_at,
                                                   ": expected at least ", points_at, ", where the points start, and ",
                                                   "at most ", file.size() - kTableHead));
  }
  const auto chunks = ScalarAt<uint32_t>(file, static_cast<size_t>(table_at) + sizeof(uint32_t));
  const uint64_t most = file.size();
  const uint64_t expected =
      chunk_points == 0 || chunk_points == kAnySize ? 0 : (points + chunk_points - 1) / chunk_points;
  if (chunks > most || (points > 0 && chunks == 0) || (expected != 0 && chunks != expected)) {
    return absl::InvalidArgumentError(absl::StrCat("the table of compressed chunks has ", chunks, " of them: expected ",
                                                   expected != 0 ? absl::StrCat(expected) : absl::StrCat("1 to ", most),
                                                   ", for ", points, " points"));
  }
  return absl::OkStatus();
}

#ifdef CURV_HAS_LAZPERF
namespace {

absl::Status LazError(const std::exception& error) {
  return absl::InvalidArgumentError(
      absl::StrCat("the compressed points cannot be read: lazperf says \"", error.what(), "\""));
}

class LazperfPoints : public LazPoints {
 public:
  // lazperf wants a pointer to what it may change, and changes nothing. Throws what lazperf throws.
  explicit LazperfPoints(std::string_view file) : reader_(const_cast<char*>(file.data()), file.size()) {}

  absl::Status Check(std::string_view file, uint64_t points, size_t record_bytes) {
    // Of older files lazperf reads the header, and takes compressed points for plain ones.
    const unsigned minor_version = reader_.header().version.minor;
    if (minor_version < 2) {
      return absl::InvalidArgumentError(
          absl::StrCat("the version is 1.", minor_version, ": lazperf reads compressed points of LAS 1.2 to 1.4"));
    }
    const size_t length = reader_.header().point_record_length;
    if (reader_.pointCount() != points || length != record_bytes) {
      return absl::InvalidArgumentError(absl::StrCat("lazperf finds ", reader_.pointCount(), " points of ", length,
                                                     " bytes: the header tells of ", points, " of ", record_bytes));
    }
    record_bytes_ = record_bytes;
    return CheckChunkTable(file, points, reader_.lazVlr().chunk_size);
  }

  absl::Status Next(size_t count, char* records) override {
    try {
      for (size_t i = 0; i < count; ++i, ++read_) reader_.readPoint(records + i * record_bytes_);
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const std::exception& error) {
      return absl::InvalidArgumentError(absl::StrCat("point ", read_, ": ", std::string(LazError(error).message())));
    }
    return absl::OkStatus();
  }

 private:
  lazperf::reader::mem_file reader_;
  size_t record_bytes_ = 0;
  uint64_t read_ = 0;
};

}  // namespace

bool CanReadLaz() { return true; }

absl::StatusOr<std::unique_ptr<LazPoints>> LazPoints::Open(std::string_view file, uint64_t points,
                                                           size_t record_bytes) {
  try {
    // The table is looked at before lazperf makes room for what it tells of.
    if (absl::Status status = CheckChunkTable(file, points, 0); !status.ok()) return status;
    auto opened = std::make_unique<LazperfPoints>(file);
    if (absl::Status status = opened->Check(file, points, record_bytes); !status.ok()) return status;
    return opened;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    return LazError(error);
  }
}

#else

bool CanReadLaz() { return false; }

absl::StatusOr<std::unique_ptr<LazPoints>> LazPoints::Open(std::string_view, uint64_t, size_t) {
  return absl::UnimplementedError("this program was built without lazperf, which decompresses LAZ");
}

#endif

}  // namespace curv
