#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/civil_time.h"
#include "absl/time/clock.h"
#include "client/io/bytes.h"
#include "client/io/las/las_plan.h"
#include "client/io/las/lattice.h"
#include "client/io/writers.h"

namespace curv {
namespace {

constexpr size_t kBlockRows = 4096;
constexpr uint16_t kWellKnownTextBit = 16;  // of the global encoding; formats from 6 on need it

// Returns `text` with zeros at its end, `bytes` long.
std::string Padded(std::string text, size_t bytes) {
  text.resize(bytes, '\0');
  return text;
}

// A file that is made of no other: of today.
LasFrame NewFrame(uint8_t point_format) {
  LasFrame frame;
  const absl::CivilDay today = absl::ToCivilDay(absl::Now(), absl::UTCTimeZone());
  frame.creation_year = static_cast<uint16_t>(today.year());
  frame.creation_day = static_cast<uint16_t>(absl::GetYearDay(today));
  frame.system_identifier = Padded("curv", 32);
  if (point_format >= 6) frame.global_encoding = kWellKnownTextBit;
  return frame;
}

// Least and largest coordinates, and how many points are the first, second, ... return of their pulse.
struct Totals {
  std::array<double, 3> low;
  std::array<double, 3> high;
  std::array<uint64_t, 15> by_return{};
};

const LasSlot* FindSlot(const LasPlan& plan, std::string_view name) {
  const auto found = std::find_if(plan.slots.begin(), plan.slots.end(),
                                  [name](const LasSlot& slot) { return slot.field.name == name; });
  return found == plan.slots.end() ? nullptr : &*found;
}

Totals TotalsOf(const LasPlan& plan, size_t points) {
  Totals totals;
  for (size_t axis = 0; axis < 3; ++axis) {
    int32_t low = std::numeric_limits<int32_t>::max(), high = std::numeric_limits<int32_t>::min();
    for (size_t i = 0; i < points; ++i) {
      const int32_t step = StepOf(plan.axes[axis], plan.coordinates[axis]->At(i));
      low = std::min(low, step);
      high = std::max(high, step);
    }
    totals.low[axis] = points == 0 ? 0.0 : plan.axes[axis].At(low);
    totals.high[axis] = points == 0 ? 0.0 : plan.axes[axis].At(high);
  }
  const LasSource returns = FindSlot(plan, "return_number")->source;
  for (size_t i = 0; i < points; ++i) {
    const double number = returns.column == nullptr ? returns.fill : returns.column->At(i);
    if (number >= 1.0 && number <= 15.0) ++totals.by_return[static_cast<size_t>(number) - 1];
  }
  return totals;
}

std::string RecordHeader(const LasRecord& record) {
  std::string header;
  AppendScalar<uint16_t>(0, header);
  header += Padded(record.user_id, 16);
  AppendScalar(record.id, header);
  if (record.extended) {
    AppendScalar<uint64_t>(record.payload.size(), header);
  } else {
    AppendScalar(static_cast<uint16_t>(record.payload.size()), header);
  }
  return header + Padded(record.description, 32);
}

size_t BytesOf(const LasRecord& record) {
  return (record.extended ? kLasExtendedRecordHeaderBytes : kLasRecordHeaderBytes) + record.payload.size();
}

// Writes a table as its plan says.
class LasWriter {
 public:
  LasWriter(const PointTable& table, const LasPlan& plan, ByteSink& file)
      : points_(table.size()),
        plan_(plan),
        frame_(table.las != nullptr ? *table.las : NewFrame(plan.point_format)),
        file_(file) {
    if (!plan.descriptors.empty()) {
      frame_.records.push_back(
          {.user_id = kLasSpecUser, .id = kLasExtraBytesId, .description = "Extra Bytes", .payload = plan.descriptors});
    }
  }

  absl::Status Write() {
    const absl::StatusOr<std::string> header = Header();
    if (!header.ok()) return header.status();
    if (absl::Status status = file_.Append(*header); !status.ok()) return status;
    if (absl::Status status = WriteRecords(false); !status.ok()) return status;
    if (absl::Status status = WritePoints(); !status.ok()) return status;
    return WriteRecords(true);
  }

 private:
  size_t header_bytes() const { return LasHeaderBytes(plan_.minor_version) + frame_.header_rest.size(); }

  absl::StatusOr<std::string> Header() const {
    size_t points_at = header_bytes(), records = 0, extended = 0;
    for (const LasRecord& record : frame_.records) {
      if (!record.extended) points_at += BytesOf(record);
      ++(record.extended ? extended : records);
    }
    if (points_at > std::numeric_limits<uint32_t>::max()) {
      return absl::InvalidArgumentError(absl::StrCat("the points would start at byte ", points_at, ": at most ",
                                                     std::numeric_limits<uint32_t>::max(), " is possible in LAS"));
    }
    const Totals totals = TotalsOf(plan_, points_);
    std::string header(LasHeaderBytes(plan_.minor_version), '\0');
    PutStart(header);
    PutScalar(static_cast<uint16_t>(header_bytes()), 94, header);
    PutScalar(static_cast<uint32_t>(points_at), 96, header);
    PutScalar(static_cast<uint32_t>(records), 100, header);
    PutScalar(plan_.point_format, 104, header);
    PutScalar(static_cast<uint16_t>(plan_.record_bytes), 105, header);
    PutLegacyCounts(totals, header);
    for (size_t axis = 0; axis < 3; ++axis) {
      PutScalar(plan_.axes[axis].scale, 131 + 8 * axis, header);
      PutScalar(plan_.axes[axis].offset, 155 + 8 * axis, header);
      PutScalar(totals.high[axis], 179 + 16 * axis, header);
      PutScalar(totals.low[axis], 187 + 16 * axis, header);
    }
    PutEnd(points_at + points_ * plan_.record_bytes, extended, totals, header);
    return header + frame_.header_rest;
  }

  void PutStart(std::string& header) const {
    header.replace(0, 4, "LASF");
    PutScalar(frame_.file_source_id, 4, header);
    PutScalar(frame_.global_encoding, 6, header);
    header.replace(8, 16, frame_.project_id);
    header[24] = 1;
    header[25] = static_cast<char>(plan_.minor_version);
    header.replace(26, 32, frame_.system_identifier);
    header.replace(58, 32, Padded("curv", 32));
    PutScalar(frame_.creation_day, 90, header);
    PutScalar(frame_.creation_year, 92, header);
  }

  // Formats from 6 on, and counts that 32 bits do not hold, leave these at 0.
  void PutLegacyCounts(const Totals& totals, std::string& header) const {
    if (plan_.minor_version >= 4 && (plan_.point_format >= 6 || points_ > std::numeric_limits<uint32_t>::max())) return;
    PutScalar(static_cast<uint32_t>(points_), 107, header);
    for (size_t i = 0; i < 5; ++i) PutScalar(static_cast<uint32_t>(totals.by_return[i]), 111 + 4 * i, header);
  }

  // What LAS 1.3 and 1.4 have added to the header.
  void PutEnd(uint64_t points_end, size_t extended, const Totals& totals, std::string& header) const {
    if (plan_.minor_version >= 3) PutScalar(WaveformsAt(points_end), 227, header);
    if (plan_.minor_version < 4) return;
    PutScalar(extended == 0 ? uint64_t{0} : points_end, 235, header);
    PutScalar(static_cast<uint32_t>(extended), 243, header);
    PutScalar(static_cast<uint64_t>(points_), 247, header);
    for (size_t i = 0; i < totals.by_return.size(); ++i) PutScalar(totals.by_return[i], 255 + 8 * i, header);
  }

  uint64_t WaveformsAt(uint64_t points_end) const {
    if (!frame_.waveform_record.has_value()) return 0;
    uint64_t at = points_end;
    for (size_t i = 0; i < *frame_.waveform_record; ++i) {
      if (frame_.records[i].extended) at += BytesOf(frame_.records[i]);
    }
    return at;
  }

  absl::Status WriteRecords(bool extended) {
    for (const LasRecord& record : frame_.records) {
      if (record.extended != extended) continue;
      if (absl::Status status = file_.Append(RecordHeader(record)); !status.ok()) return status;
      if (absl::Status status = file_.Append(record.payload); !status.ok()) return status;
    }
    return absl::OkStatus();
  }

  absl::Status WritePoints() {
    std::string block;
    for (size_t begin = 0; begin < points_; begin += kBlockRows) {
      const size_t count = std::min(kBlockRows, points_ - begin);
      block.assign(count * plan_.record_bytes, '\0');
      for (size_t axis = 0; axis < 3; ++axis) {
        for (size_t i = 0; i < count; ++i) {
          PutScalar(StepOf(plan_.axes[axis], plan_.coordinates[axis]->At(begin + i)),
                    i * plan_.record_bytes + axis * sizeof(int32_t), block);
        }
      }
      for (const LasSlot& slot : plan_.slots) {
        Store(slot.field, slot.source, begin, count, plan_.record_bytes, block.data());
      }
      if (absl::Status status = file_.Append(block); !status.ok()) return status;
    }
    return absl::OkStatus();
  }

  size_t points_;
  const LasPlan& plan_;
  LasFrame frame_;
  ByteSink& file_;
};

}  // namespace

absl::Status WriteLas(const PointTable& table, ByteSink& file) {
  const absl::StatusOr<LasPlan> plan = PlanLas(table);
  if (!plan.ok()) return absl::InvalidArgumentError(absl::StrCat("cannot write LAS: ", plan.status().message()));
  return LasWriter(table, *plan, file).Write();
}

}  // namespace curv
