#include "client/tiles/reading/json_fields.h"

#include "absl/strings/str_cat.h"

namespace curv {
namespace {

// Copying and printing take stack for each level.
constexpr int kMostDepth = 8;

}  // namespace

nlohmann::ordered_json ParseFields(std::string_view text) {
  using Json = nlohmann::ordered_json;
  const auto check = [](int depth, Json::parse_event_t, Json&) {
    if (depth > kMostDepth) throw BadField(absl::StrCat("it is nested deeper than ", kMostDepth, " levels"));
    return true;
  };
  return Json::parse(text, check);
}

uint64_t UnsignedOf(const nlohmann::ordered_json& object, const char* name, uint64_t most) {
  const nlohmann::ordered_json& value = object.at(name);
  if (!value.is_number_unsigned() || value.get<uint64_t>() > most) {
    throw BadField(absl::StrCat(name, " is not a whole number from 0 to ", most));
  }
  return value.get<uint64_t>();
}

double NumberOf(const nlohmann::ordered_json& object, const char* name, double least, double most) {
  const nlohmann::ordered_json& value = object.at(name);
  if (!value.is_number() || !(value.get<double>() >= least && value.get<double>() <= most)) {
    throw BadField(absl::StrCat(name, " is not a number from ", least, " to ", most));
  }
  return value.get<double>();
}

}  // namespace curv
