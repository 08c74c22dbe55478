#include "client/io/las/las_plan.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <set>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "client/io/las/extra_bytes.h"
#include "client/io/las/lattice.h"

namespace curv {
namespace {

constexpr const char* kColors[] = {"red", "green", "blue"};
constexpr double kBytesToWords = 257.0;  // 255 becomes 65,535

class Planner {
 public:
  explicit Planner(const PointTable& table) : table_(table) {
    for (const Column& column : table.columns()) left_.insert(column.name);
  }

  absl::StatusOr<LasPlan> Plan() {
    ChooseFormat();
    if (absl::Status status = PlaceCoordinates(); !status.ok()) return status;
    PlaceStandardFields();
    KeepExtras();
    AddExtras();
    if (absl::Status status = CheckLimits(); !status.ok()) return status;
    return std::move(plan_);
  }

 private:
  bool HasColors() const {
    const Column* const red = table_.Find("red");
    if (red == nullptr || (red->kind() != ScalarKind::kUint8 && red->kind() != ScalarKind::kUint16)) return false;
    return std::all_of(std::begin(kColors), std::end(kColors), [this, red](const char* name) {
      const Column* const column = table_.Find(name);
      return column != nullptr && column->kind() == red->kind();
    });
  }

  void ChooseFormat() {
    if (table_.las != nullptr) {
      plan_.minor_version = std::max<uint8_t>(2, table_.las->minor_version);
      plan_.point_format = table_.las->point_format;
    } else if (table_.Find("scan_angle_rank") != nullptr) {
      plan_.point_format = table_.Find("gps_time") != nullptr ? 1 : 0;
    } else if (HasColors() && table_.Find("nir") != nullptr) {
      plan_.point_format = 8;
    }
    if (HasColors()) plan_.point_format = WithColors(plan_.point_format);
  }

  absl::Status PlaceCoordinates() {
    static constexpr const char* kNames[] = {"x", "y", "z"};
    for (size_t axis = 0; axis < 3; ++axis) {
      const Column* const column = table_.Find(kNames[axis]);
      if (column == nullptr) {
        return absl::InvalidArgumentError(
            absl::StrCat("there is no column ", kNames[axis], ": points of LAS have x, y and z"));
      }
      std::optional<LasAxis> preferred;
      if (table_.las != nullptr) preferred = table_.las->axes[axis];
      const absl::StatusOr<LasAxis> lattice = ChooseAxis(*column, preferred);
      if (!lattice.ok()) return lattice.status();
      plan_.coordinates[axis] = column;
      plan_.axes[axis] = *lattice;
      left_.erase(kNames[axis]);
    }
    return absl::OkStatus();
  }

  // The source of a field, if the table has one that fits; its columns are then taken.
  std::optional<LasSource> Take(const LasField& field) {
    const Column* const column = Left(field.name);
    if (column != nullptr && Fits(field, *column)) {
      left_.erase(field.name);
      return LasSource{.column = column};
    }
    const Column* const low = Left(field.name + "_low");
    const Column* const high = Left(field.name + "_high");
    const auto is_half = [](const Column* half) { return half != nullptr && half->kind() == ScalarKind::kUint32; };
    if (!field.is_wide() || !is_half(low) || !is_half(high)) return std::nullopt;
    left_.erase(low->name);
    left_.erase(high->name);
    return LasSource{.column = low, .high = high};
  }

  const Column* Left(const std::string& name) const { return left_.contains(name) ? table_.Find(name) : nullptr; }

  void PlaceStandardFields() {
    const bool small_colors = HasColors() && table_.Find("red")->kind() == ScalarKind::kUint8;
    plan_.record_bytes = LasRecordBytes(plan_.point_format);
    for (LasField& field : StandardFields(plan_.point_format)) {
      names_.insert(field.name);
      std::optional<LasSource> source = Take(field);
      // A point whose returns nobody counted is the only one of its pulse.
      const bool counts_returns = field.name == "return_number" || field.name == "number_of_returns";
      if (!source.has_value()) source = LasSource{.fill = counts_returns ? 1.0 : 0.0};
      const bool is_color = std::find(std::begin(kColors), std::end(kColors), field.name) != std::end(kColors);
      if (is_color && small_colors) source->factor = kBytesToWords;
      plan_.slots.push_back({std::move(field), *source});
    }
  }

  // Attributes that the table's file had, in their types and with their descriptions.
  void KeepExtras() {
    if (table_.las == nullptr) return;
    for (const LasExtra& extra : table_.las->extras) {
      std::vector<LasSlot> slots;
      const std::set<std::string> left_before = left_;
      for (LasField& field : FieldsOf(extra, plan_.record_bytes)) {
        const std::optional<LasSource> source = Take(field);
        if (source.has_value()) slots.push_back({std::move(field), *source});
      }
      if (slots.size() < extra.columns.size()) {
        left_ = left_before;
        continue;
      }
      Add(extra, std::move(slots));
    }
  }

  void AddExtras() {
    // First, so that no column that is called normal_x takes their names.
    for (const char* normal : {"nx", "ny", "nz"}) {
      if (left_.contains(normal)) AddExtra(*table_.Find(normal));
      left_.erase(normal);
    }
    for (const Column& column : table_.columns()) {
      if (left_.contains(column.name)) AddExtra(column);
    }
  }

  void AddExtra(const Column& column) {
    const LasExtra extra = DescribeColumn(column, names_);
    std::vector<LasSlot> slots;
    for (LasField& field : FieldsOf(extra, plan_.record_bytes)) {
      slots.push_back({std::move(field), LasSource{.column = &column}});
    }
    Add(extra, std::move(slots));
  }

  void Add(const LasExtra& extra, std::vector<LasSlot> slots) {
    plan_.descriptors += extra.descriptor;
    plan_.record_bytes += BytesOf(extra);
    names_.emplace(NameOf(extra));
    std::move(slots.begin(), slots.end(), std::back_inserter(plan_.slots));
  }

  absl::Status CheckLimits() const {
    const size_t extras = plan_.descriptors.size() / kLasDescriptorBytes;
    if (extras > kMaxLasExtras) {
      return absl::InvalidArgumentError(absl::StrCat(
          "the points have ", extras, " attributes beyond those of LAS: a file describes at most ", kMaxLasExtras));
    }
    constexpr size_t kMaxRecordBytes = std::numeric_limits<uint16_t>::max();
    if (plan_.record_bytes > kMaxRecordBytes) {
      return absl::InvalidArgumentError(absl::StrCat("a point takes ", plan_.record_bytes, " bytes: at most ",
                                                     kMaxRecordBytes, " are possible in LAS"));
    }
    constexpr size_t kMaxLegacyPoints = std::numeric_limits<uint32_t>::max();
    if (plan_.minor_version < 4 && table_.size() > kMaxLegacyPoints) {
      return absl::InvalidArgumentError(absl::StrCat("there are ", table_.size(), " points: LAS 1.",
                                                     static_cast<unsigned>(plan_.minor_version), " holds at most ",
                                                     kMaxLegacyPoints));
    }
    return absl::OkStatus();
  }

  const PointTable& table_;
  std::set<std::string> left_;   // columns without a place so far
  std::set<std::string> names_;  // of attributes in the file
  LasPlan plan_;
};

}  // namespace

absl::StatusOr<LasPlan> PlanLas(const PointTable& table) { return Planner(table).Plan(); }

}  // namespace curv
