#include "server/call/wire_options.h"

#include <string>
#include <type_traits>

#include "absl/strings/str_cat.h"
#include "core/estimators/option_specs.h"
#include "google/protobuf/message.h"
#include "server/rpc/error_detail.h"
#include "server/rpc/error_reasons.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;
using google::protobuf::FieldDescriptor;
using google::protobuf::Reflection;

const FieldDescriptor* FieldOf(const OptionSpec& spec) {
  return v1::EstimatorOptions::descriptor()->FindFieldByName(std::string(spec.name));
}

template <typename T>
T Get(const v1::EstimatorOptions& proto, const FieldDescriptor* field) {
  const Reflection& reflection = *proto.GetReflection();
  if constexpr (std::is_same_v<T, uint32_t>) return reflection.GetUInt32(proto, field);
  if constexpr (std::is_same_v<T, uint64_t>) return reflection.GetUInt64(proto, field);
  if constexpr (std::is_same_v<T, double>) return reflection.GetDouble(proto, field);
  if constexpr (std::is_same_v<T, bool>) return reflection.GetBool(proto, field);
}

template <typename T>
void Set(T value, const FieldDescriptor* field, v1::EstimatorOptions& proto) {
  const Reflection& reflection = *proto.GetReflection();
  if constexpr (std::is_same_v<T, uint32_t>) reflection.SetUInt32(&proto, field, value);
  if constexpr (std::is_same_v<T, uint64_t>) reflection.SetUInt64(&proto, field, value);
  if constexpr (std::is_same_v<T, double>) reflection.SetDouble(&proto, field, value);
  if constexpr (std::is_same_v<T, bool>) reflection.SetBool(&proto, field, value);
}

std::string RangeText(const OptionSpec& spec) {
  if (std::holds_alternative<double EstimatorOptions::*>(spec.member)) {
    return absl::StrCat("in [", spec.least, ", ", spec.most, "]");
  }
  // 0 is the default, so nothing is below 1.
  if (spec.least <= 1) return absl::StrCat("at most ", spec.most);
  return absl::StrCat("from ", spec.least, " to ", spec.most);
}

}  // namespace

absl::Status ReadOptions(const v1::EstimatorOptions& proto, EstimatorOptions& options) {
  for (const OptionSpec& spec : OptionSpecs()) {
    const FieldDescriptor* field = FieldOf(spec);
    // Without presence a field is there if it is not 0.
    if (!proto.GetReflection()->HasField(proto, field)) continue;
    std::visit([&]<typename T>(T EstimatorOptions::*member) { options.*member = Get<T>(proto, field); }, spec.member);
    if (spec.InRange(options)) continue;
    return MakeError(absl::StatusCode::kInvalidArgument, {kReasonInvalidOption,
                                                          absl::StrCat("header.options.", std::string(spec.name)),
                                                          spec.ValueText(options),
                                                          RangeText(spec),
                                                          {}});
  }
  return absl::OkStatus();
}

void WriteOptions(const EstimatorOptions& options, v1::EstimatorOptions& proto) {
  for (const OptionSpec& spec : OptionSpecs()) {
    std::visit([&](auto member) { Set(options.*member, FieldOf(spec), proto); }, spec.member);
  }
}

}  // namespace curvd
