#include "client/io/las/extra_bytes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/io/bytes.h"
#include "client/io/names/column_names.h"
#include "client/io/point_status.h"
#include "client/io/text.h"
#include "client/io/writers.h"

namespace curv {
namespace {

constexpr uint8_t kUndocumented = 0;
constexpr uint8_t kFirstArray = 11;  // to 30: deprecated arrays of two and three scalars
constexpr uint8_t kLastArray = 30;
constexpr size_t kMaxUndocumented = 1024;
// Bytes of a descriptor.
constexpr size_t kTypeAt = 2, kOptionsAt = 3, kNameAt = 4, kNoDataAt = 40, kMinAt = 64, kMaxAt = 88, kScaleAt = 112,
                 kOffsetAt = 136, kDescriptionAt = 160, kTextBytes = 32;
// Bits of its options.
constexpr uint8_t kHasNoData = 1, kHasMin = 2, kHasMax = 4, kHasScale = 8, kHasOffset = 16;

constexpr std::pair<std::string_view, std::string_view> kNormals[] = {
    {"normal_x", "nx"}, {"normal_y", "ny"}, {"normal_z", "nz"}};

uint8_t ByteAt(std::string_view bytes, size_t at) { return static_cast<uint8_t>(bytes[at]); }

// How many scalars a value of the attribute has.
size_t Components(uint8_t data_type) { return data_type < kFirstArray ? 1 : data_type <= 20 ? 2 : 3; }

LasType ScalarOf(uint8_t data_type) { return static_cast<LasType>((data_type - 1) % 10 + 1); }

// A name that `used` does not have, nor the names of its halves, which integers of 64 bits may become.
std::string Unique(std::string name, std::set<std::string>& used) {
  const std::string first = name;
  const auto is_used = [&used](const std::string& candidate) {
    return used.contains(candidate) || used.contains(candidate + "_low") || used.contains(candidate + "_high");
  };
  for (int number = 2; is_used(name); ++number) name = absl::StrCat(first, "_", number);
  used.insert(name);
  return name;
}

// The first bytes of a name, at most `most`, without a part of a letter of UTF-8 at their end.
std::string Shortened(std::string name, size_t most) {
  if (name.size() <= most) return name;
  while (most > 0 && (static_cast<uint8_t>(name[most]) & 0xC0) == 0x80) --most;
  name.resize(most);
  return name;
}

// Names for bytes of which nothing is known: undocumented, undocumented_2 and so on.
class UndocumentedNames {
 public:
  explicit UndocumentedNames(std::set<std::string>& used) : used_(used) {}

  std::string Next() {
    // Counted on, as there can be many: to try all numbers for each would take the square of their count.
    std::string name = "undocumented";
    do {
      if (++count_ > 1) name = absl::StrCat("undocumented_", count_);
    } while (!used_.insert(name).second);
    return name;
  }

 private:
  std::set<std::string>& used_;
  int count_ = 0;
};

void ReserveHalves(const std::string& name, std::set<std::string>& used) {
  used.insert({name + "_low", name + "_high"});
}

// Positions are no extra attributes, whatever one is called.
std::string ColumnName(std::string_view name) {
  const std::string in_table = TableName(name);
  if (in_table.size() == 2) return in_table;
  return name.empty() ? "extra" : std::string(name);
}

std::vector<std::string> ColumnNames(std::string_view name, uint8_t data_type, std::set<std::string>& used) {
  const size_t count = Components(data_type);
  const LasType type = ScalarOf(data_type);
  std::vector<std::string> names;
  for (size_t i = 0; i < count; ++i) {
    names.push_back(Unique(count == 1 ? ColumnName(name) : absl::StrCat(std::string(name), "_", i), used));
    if (type == LasType::kUint64 || type == LasType::kInt64) ReserveHalves(names.back(), used);
  }
  return names;
}

// No-data values are stored in 8 bytes, of the widest type of the scalar's sort.
double NoData(std::string_view descriptor, size_t component, LasType type) {
  const size_t at = kNoDataAt + 8 * component;
  if (type >= LasType::kFloat32) return ScalarAt<double>(descriptor, at);
  const bool is_signed =
      type == LasType::kInt8 || type == LasType::kInt16 || type == LasType::kInt32 || type == LasType::kInt64;
  return is_signed ? static_cast<double>(ScalarAt<int64_t>(descriptor, at))
                   : static_cast<double>(ScalarAt<uint64_t>(descriptor, at));
}

std::optional<LasScaling> ScalingOf(std::string_view descriptor, size_t component, LasType type) {
  const uint8_t options = ByteAt(descriptor, kOptionsAt);
  if ((options & (kHasScale | kHasOffset)) == 0) return std::nullopt;
  LasScaling scaling;
  if ((options & kHasScale) != 0) scaling.scale = ScalarAt<double>(descriptor, kScaleAt + 8 * component);
  if ((options & kHasOffset) != 0) scaling.offset = ScalarAt<double>(descriptor, kOffsetAt + 8 * component);
  if (!std::isfinite(scaling.scale) || scaling.scale == 0.0 || !std::isfinite(scaling.offset)) return std::nullopt;
  if ((options & kHasNoData) != 0) scaling.no_data = NoData(descriptor, component, type);
  return scaling;
}

void NoteBadScaling(const LasExtra& extra, std::vector<std::string>& notes) {
  const uint8_t options = ByteAt(extra.descriptor, kOptionsAt);
  if (extra.data_type() == kUndocumented || (options & (kHasScale | kHasOffset)) == 0) return;
  for (size_t i = 0; i < extra.columns.size(); ++i) {
    if (ScalingOf(extra.descriptor, i, ScalarOf(extra.data_type())).has_value()) continue;
    notes.push_back(absl::StrCat("column ", Printable(extra.columns[i]),
                                 " has the values that are stored: its scale is 0, or scale or offset are not finite"));
  }
}

// The extremes were those of other points. The options of undocumented bytes are their number.
void ForgetExtremes(std::string& descriptor) {
  if (ByteAt(descriptor, kTypeAt) == kUndocumented) return;
  descriptor[kOptionsAt] = static_cast<char>(descriptor[kOptionsAt] & ~(kHasMin | kHasMax));
  std::fill_n(descriptor.begin() + kMinAt, kScaleAt - kMinAt, '\0');
  static_assert(kMaxAt - kMinAt == 24 && kScaleAt - kMaxAt == 24);
}

LasExtra NewExtra(uint8_t data_type, uint8_t options, std::string_view name, std::string_view description) {
  LasExtra extra{.descriptor = std::string(kLasDescriptorBytes, '\0'), .columns = {}};
  extra.descriptor[kTypeAt] = static_cast<char>(data_type);
  extra.descriptor[kOptionsAt] = static_cast<char>(options);
  std::copy(name.begin(), name.end(), extra.descriptor.begin() + kNameAt);
  std::copy(description.begin(), description.end(), extra.descriptor.begin() + kDescriptionAt);
  return extra;
}

// Appends undocumented bytes, 255 of them to an attribute.
void AddUndocumented(size_t count, UndocumentedNames& names, std::vector<std::string>& notes,
                     std::vector<LasExtra>& extras) {
  if (count > kMaxUndocumented) {
    notes.push_back(absl::StrCat("left out ", count - kMaxUndocumented, " of ", count,
                                 " bytes of each point that nothing describes: at most ", kMaxUndocumented,
                                 " are kept"));
    count = kMaxUndocumented;
  }
  while (count > 0) {
    LasExtra extra = DescribeUndocumented(std::min<size_t>(count, 255));
    count -= BytesOf(extra);
    for (size_t i = 0; i < BytesOf(extra); ++i) extra.columns.push_back(names.Next());
    extras.push_back(std::move(extra));
  }
}

}  // namespace

std::vector<LasExtra> ReadDescriptors(std::string_view descriptors, size_t extra_bytes, std::set<std::string>& used,
                                      std::vector<std::string>& notes) {
  std::vector<LasExtra> extras;
  const std::set<std::string> used_before = used;
  UndocumentedNames undocumented(used);
  size_t left = extra_bytes;
  for (; !descriptors.empty(); descriptors.remove_prefix(kLasDescriptorBytes)) {
    LasExtra extra{.descriptor = std::string(descriptors.substr(0, kLasDescriptorBytes)), .columns = {}};
    ForgetExtremes(extra.descriptor);
    if (extra.data_type() > kLastArray) {
      notes.push_back(absl::StrCat("extra attribute ", extras.size(), " has data type ",
                                   static_cast<unsigned>(extra.data_type()),
                                   ": expected 0 to 30; its bytes and those behind are kept as undocumented ones"));
      break;
    }
    const size_t bytes = BytesOf(extra);
    if (bytes == 0) continue;
    if (bytes > left) {
      notes.push_back(absl::StrCat("the extra attributes take more than the ", extra_bytes,
                                   " bytes that points have for them: they are kept as undocumented ones"));
      extras.clear();
      used = used_before;
      left = extra_bytes;
      break;
    }
    left -= bytes;
    const std::string_view name = NameOf(extra);
    if (extra.data_type() == kUndocumented) {
      for (size_t i = 0; i < bytes; ++i) extra.columns.push_back(undocumented.Next());
    } else {
      extra.columns = ColumnNames(name, extra.data_type(), used);
      NoteBadScaling(extra, notes);
    }
    extras.push_back(std::move(extra));
  }
  AddUndocumented(left, undocumented, notes, extras);
  return extras;
}

std::string_view NameOf(const LasExtra& extra) {
  return TextOf(std::string_view(extra.descriptor).substr(kNameAt, kTextBytes));
}

size_t BytesOf(const LasExtra& extra) {
  if (extra.data_type() == kUndocumented) return ByteAt(extra.descriptor, kOptionsAt);
  return Components(extra.data_type()) * BytesOf(ScalarOf(extra.data_type()));
}

std::vector<LasField> FieldsOf(const LasExtra& extra, size_t offset) {
  const bool undocumented = extra.data_type() == kUndocumented;
  const LasType type = undocumented ? LasType::kUint8 : ScalarOf(extra.data_type());
  std::vector<LasField> fields;
  for (size_t i = 0; i < extra.columns.size(); ++i) {
    fields.push_back({.name = extra.columns[i], .type = type, .offset = offset + i * BytesOf(type), .scaling = {}});
    if (!undocumented) fields.back().scaling = ScalingOf(extra.descriptor, i, type);
  }
  return fields;
}

LasExtra DescribeColumn(const Column& column, std::set<std::string>& used) {
  // In the order of ScalarKind.
  static constexpr LasType kTypes[] = {LasType::kInt8,  LasType::kUint8,  LasType::kInt16,   LasType::kUint16,
                                       LasType::kInt32, LasType::kUint32, LasType::kFloat32, LasType::kFloat64};
  std::string name = column.name;
  for (const auto& [in_file, in_table] : kNormals) {
    if (name == in_table) name = in_file;
  }
  std::string short_name = Shortened(HeaderName(name), kMaxLasName);
  for (int number = 2; !used.insert(short_name).second; ++number) {
    const std::string tail = absl::StrCat("_", number);
    short_name = Shortened(HeaderName(name), kMaxLasName - tail.size()) + tail;
  }
  LasExtra extra = NewExtra(static_cast<uint8_t>(kTypes[static_cast<size_t>(column.kind())]), 0, short_name,
                            IsStatusName(column.name) ? "1: ok, else why there is none" : "");
  extra.columns.push_back(column.name);
  return extra;
}

LasExtra DescribeUndocumented(size_t count) {
  return NewExtra(kUndocumented, static_cast<uint8_t>(count), "undocumented", "");
}

}  // namespace curv
