#include "client/io/pcd/pcd_header.h"

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "client/io/text.h"

namespace curv {
namespace {

// What the lines of a header say, one by one.
struct HeaderLines {
  std::vector<PcdField> fields;
  std::optional<uint64_t> points;
  std::optional<uint64_t> width;
  std::optional<uint64_t> height;
  std::optional<std::array<double, 3>> viewpoint;
  std::array<double, 4> rotation = PcdFrame().rotation;
  std::string encoding;
};

absl::Status ErrorAt(size_t line, const std::string& problem) {
  return absl::InvalidArgumentError(absl::StrCat("line ", line, ": ", problem));
}

// Reads "NAME value value ...", one value a field, into a member of the fields.
template <typename T>
absl::Status ReadEach(std::string_view rest, size_t line, const std::string& keyword, T PcdField::*member,
                      std::vector<PcdField>& fields) {
  for (PcdField& field : fields) {
    const std::string_view word = NextField(rest);
    bool good;
    if constexpr (std::is_same_v<T, char>) {
      good = word.size() == 1;
      if (good) field.*member = word[0];
    } else {
      good = ParseNumber(word, field.*member);
    }
    if (!good) return ErrorAt(line, absl::StrCat(keyword, " of field ", Printable(field.name), " is ", Quoted(word)));
  }
  if (!NextField(rest).empty()) {
    return ErrorAt(line, absl::StrCat(keyword, " has more values than the ", fields.size(), " FIELDS"));
  }
  return absl::OkStatus();
}

absl::Status ReadCount(std::string_view rest, size_t line, const std::string& keyword, std::optional<uint64_t>& count) {
  const std::string_view word = NextField(rest);
  uint64_t value;
  if (!ParseNumber(word, value)) {
    return ErrorAt(line, absl::StrCat(keyword, " is ", Quoted(word), ": expected an integer of 0 or more"));
  }
  count = value;
  return absl::OkStatus();
}

// Reads that many finite numbers from the start of a line; nothing where they are not there.
template <size_t kSize>
std::optional<std::array<double, kSize>> ReadFinite(std::string_view& rest) {
  std::array<double, kSize> numbers;
  for (double& number : numbers) {
    if (!ParseNumber(NextField(rest), number) || !std::isfinite(number)) return std::nullopt;
  }
  return numbers;
}

// The position "x y z" unless it is 0 0 0, then how the sensor was turned. Neither has an effect on the points, so that
// nothing is refused.
void ReadViewpoint(std::string_view rest, HeaderLines& header) {
  header.rotation = PcdFrame().rotation;
  header.viewpoint = ReadFinite<3>(rest);
  if (!header.viewpoint.has_value()) return;
  if (header.viewpoint == std::array<double, 3>{}) header.viewpoint.reset();
  header.rotation = ReadFinite<4>(rest).value_or(header.rotation);
}

absl::Status ReadHeaderLine(std::string_view line, size_t number, HeaderLines& header) {
  const std::string keyword(NextField(line));
  if (keyword.empty() || keyword.front() == '#' || keyword == "VERSION") {
    return absl::OkStatus();
  }
  if (keyword == "FIELDS" || keyword == "COLUMNS") {
    header.fields.clear();
    for (std::string_view name; !(name = NextField(line)).empty();) {
      header.fields.emplace_back().name = std::string(name);
    }
    return absl::OkStatus();
  }
  if (keyword == "SIZE") return ReadEach(line, number, keyword, &PcdField::bytes, header.fields);
  if (keyword == "TYPE") return ReadEach(line, number, keyword, &PcdField::type, header.fields);
  if (keyword == "COUNT") return ReadEach(line, number, keyword, &PcdField::count, header.fields);
  if (keyword == "WIDTH") return ReadCount(line, number, keyword, header.width);
  if (keyword == "HEIGHT") return ReadCount(line, number, keyword, header.height);
  if (keyword == "POINTS") return ReadCount(line, number, keyword, header.points);
  if (keyword == "VIEWPOINT") {
    ReadViewpoint(line, header);
    return absl::OkStatus();
  }
  if (keyword == "DATA") {
    header.encoding = std::string(NextField(line));
    return absl::OkStatus();
  }
  return ErrorAt(number, absl::StrCat("unknown keyword ", Quoted(keyword), " in the header of a PCD file"));
}

bool IsKnownType(const PcdField& field) {
  if (field.type == 'F') return field.bytes == 4 || field.bytes == 8;
  return (field.type == 'I' || field.type == 'U') &&
         (field.bytes == 1 || field.bytes == 2 || field.bytes == 4 || field.bytes == 8);
}

// Checks what the lines say together, and resolves the number of points.
absl::Status CheckHeader(size_t line, HeaderLines& header) {
  constexpr uint64_t kMaxValues = 65'536;
  if (header.fields.empty()) return ErrorAt(line, "the header names no FIELDS");
  if (header.fields.size() > kMaxColumns) {
    return ErrorAt(line, absl::StrCat("a point has ", header.fields.size(), " FIELDS: expected at most ", kMaxColumns));
  }
  uint64_t values = 0;
  for (const PcdField& field : header.fields) {
    if (!IsKnownType(field)) {
      return ErrorAt(line,
                     absl::StrCat("field ", Printable(field.name), " has TYPE ", Printable({&field.type, 1}), ", SIZE ",
                                  field.bytes, ": expected I or U of 1, 2, 4 or 8 bytes, or F of 4 or 8"));
    }
    values += field.count;
  }
  if (values > kMaxValues) {
    return ErrorAt(line, absl::StrCat("a point has ", values, " values: expected at most ", kMaxValues));
  }
  if (!header.points) {
    if (!header.width || !header.height) return ErrorAt(line, "the header has neither POINTS nor WIDTH and HEIGHT");
    if (*header.height != 0 && *header.width > std::numeric_limits<uint64_t>::max() / *header.height) {
      return ErrorAt(line, "WIDTH times HEIGHT is too large");
    }
    header.points = *header.width * *header.height;
  }
  return absl::OkStatus();
}

// REQUIRES: the header has been checked.
PcdFrame FrameOf(const HeaderLines& header) {
  PcdFrame frame{.rotation = header.rotation};
  const uint64_t width = header.width.value_or(0), height = header.height.value_or(0);
  if (height > 1 && width == *header.points / height && *header.points % height == 0) {
    frame.width = width;
    frame.height = height;
  }
  return frame;
}

}  // namespace

absl::StatusOr<PcdHeader> ReadPcdHeader(std::string_view bytes) {
  LineReader lines(WithoutByteOrderMark(bytes));
  HeaderLines header;
  std::string_view line;
  while (header.encoding.empty()) {
    if (!lines.Next(line)) return ErrorAt(lines.number() + 1, "the header of a PCD file does not end: expected DATA");
    if (absl::Status status = ReadHeaderLine(line, lines.number(), header); !status.ok()) return status;
  }
  if (absl::Status status = CheckHeader(lines.number(), header); !status.ok()) return status;
  return PcdHeader{std::move(header.fields),   *header.points, header.viewpoint, FrameOf(header),
                   std::move(header.encoding), lines.number(), lines.rest()};
}

}  // namespace curv
