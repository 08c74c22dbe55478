#include "client/io/archive/inflate.h"

#include <zlib.h>

#include <algorithm>
#include <limits>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace curv {
namespace {

constexpr int kRawWindow = -15;
constexpr int kGzipWindow = 15 + 16;
// zlib counts in 32 bits.
constexpr size_t kMostAtOnce = size_t{1} << 30;

// Inflates bytes piece by piece.
class Inflater {
 public:
  Inflater(std::string_view packed, int window) : rest_(packed) { ready_ = inflateInit2(&stream_, window) == Z_OK; }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;
  ~Inflater() {
    if (ready_) inflateEnd(&stream_);
  }

  // Fills up to `room` bytes at `out`, and returns how many; fewer at the end of the stream, and where it is damaged.
  size_t Fill(char* out, size_t room) {
    size_t filled = 0;
    while (ready_ && !ended_ && filled < room) {
      const size_t piece = std::min(room - filled, kMostAtOnce), given = std::min(rest_.size(), kMostAtOnce);
      // zlib does not write to its input, though its type says that it could.
      stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(rest_.data()));
      stream_.avail_in = static_cast<uInt>(given);
      stream_.next_out = reinterpret_cast<Bytef*>(out + filled);
      stream_.avail_out = static_cast<uInt>(piece);
      const int result = inflate(&stream_, Z_NO_FLUSH);
      rest_.remove_prefix(given - stream_.avail_in);
      filled += piece - stream_.avail_out;
      ended_ = result == Z_STREAM_END;
      if (result != Z_OK && !ended_) break;
    }
    return filled;
  }

  bool ended() const { return ended_; }
  std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
  z_stream stream_{};
  bool ready_ = false;
  bool ended_ = false;
};

}  // namespace

absl::StatusOr<std::string> InflateRaw(std::string_view packed, uint64_t bytes) {
  // Deflate makes at most 258 bytes of 2 bits.
  constexpr uint64_t kMostGrowth = 1032;
  if (bytes / kMostGrowth > packed.size()) {
    return absl::InvalidArgumentError(
        absl::StrCat("declares ", bytes, " bytes: its ", packed.size(), " packed ones cannot hold them"));
  }
  std::string plain(bytes, '\0');
  Inflater inflater(packed, kRawWindow);
  const size_t filled = inflater.Fill(plain.data(), plain.size());
  // The end of the stream is seen only where more would follow.
  char beyond;
  const bool is_more = filled == plain.size() && inflater.Fill(&beyond, 1) > 0;
  if (filled == plain.size() && inflater.ended() && !is_more) return plain;
  return absl::InvalidArgumentError(
      absl::StrCat("is damaged: it gives ", filled, is_more ? " or more" : "", " of ", bytes, " bytes"));
}

bool IsGzip(std::string_view bytes) { return bytes.substr(0, 2) == "\x1f\x8b"; }

absl::StatusOr<std::string> Gunzip(std::string_view packed, uint64_t most_bytes) {
  constexpr size_t kFirst = 1 << 16;
  const size_t most = std::min<uint64_t>(most_bytes, std::numeric_limits<size_t>::max());
  std::string plain;
  size_t filled = 0;
  do {
    Inflater inflater(packed, kGzipWindow);
    while (!inflater.ended()) {
      if (filled == plain.size()) plain.resize(std::min(std::max(kFirst, 2 * plain.size()), most));
      if (filled == plain.size()) {
        // The end of the stream may be all that is left.
        char beyond;
        if (inflater.Fill(&beyond, 1) == 0 && inflater.ended()) break;
        return absl::InvalidArgumentError(absl::StrCat("the gzip data unpacks to more than ", most_bytes, " bytes"));
      }
      const size_t piece = inflater.Fill(plain.data() + filled, plain.size() - filled);
      filled += piece;
      if (piece == 0 && !inflater.ended()) {
        return absl::InvalidArgumentError(
            absl::StrCat("the gzip data is damaged or cut off: it ends after ", filled, " unpacked bytes"));
      }
    }
    packed = inflater.rest();
  } while (IsGzip(packed));
  // Zeros fill up the blocks of a tape.
  if (packed.find_first_not_of('\0') != std::string_view::npos) {
    return absl::InvalidArgumentError(
        absl::StrCat("the gzip data is damaged: ", packed.size(), " bytes that are not gzip data follow its end"));
  }
  plain.resize(filled);
  return plain;
}

}  // namespace curv
