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
  try {
    return Json::parse(text, check);
  } catch (const Json::parse_error& error) {
    throw BadField(error.byte > text.size() ? absl::StrCat("the JSON ends too early, after ", text.size(), " bytes")
                                            : absl::StrCat("the JSON is damaged at byte ", error.byte));
  } catch (const Json::out_of_range&) {
    throw BadField("a number is larger than a double can be");
  }
}

const nlohmann::ordered_json& MemberOf(const nlohmann::ordered_json& object, const char* name) {
  if (!object.is_object()) throw BadField(absl::StrCat("expected an object with the member ", name));
  const auto member = object.find(name);
  if (member == object.end()) throw BadField(absl::StrCat(name, " is missing"));
  return *member;
}

const nlohmann::ordered_json& ArrayOf(const nlohmann::ordered_json& object, const char* name) {
  const nlohmann::ordered_json& value = MemberOf(object, name);
  if (!value.is_array()) throw BadField(absl::StrCat(name, " is not an array"));
  return value;
}

std::string TextOf(const nlohmann::ordered_json& object, const char* name) {
  const nlohmann::ordered_json& value = MemberOf(object, name);
  if (!value.is_string()) throw BadField(absl::StrCat(name, " is not a text"));
  return value.get<std::string>();
}

std::vector<std::string> TextsOf(const nlohmann::ordered_json& object, const char* name) {
  std::vector<std::string> texts;
  for (const nlohmann::ordered_json& value : ArrayOf(object, name)) {
    if (!value.is_string()) throw BadField(absl::StrCat(name, " is not an array of texts"));
    texts.push_back(value.get<std::string>());
  }
  return texts;
}

bool FlagOf(const nlohmann::ordered_json& object, const char* name) {
  const nlohmann::ordered_json& value = MemberOf(object, name);
  if (!value.is_boolean()) throw BadField(absl::StrCat(name, " is neither true nor false"));
  return value.get<bool>();
}

int64_t IntegerOf(const nlohmann::ordered_json& object, const char* name) {
  const nlohmann::ordered_json& value = MemberOf(object, name);
  if (!value.is_number_integer()) throw BadField(absl::StrCat(name, " is not a whole number"));
  return value.get<int64_t>();
}

uint64_t UnsignedOf(const nlohmann::ordered_json& object, const char* name, uint64_t most) {
  const nlohmann::ordered_json& value = MemberOf(object, name);
  if (!value.is_number_unsigned() || value.get<uint64_t>() > most) {
    throw BadField(absl::StrCat(name, " is not a whole number from 0 to ", most));
  }
  return value.get<uint64_t>();
}

double NumberOf(const nlohmann::ordered_json& object, const char* name, double least, double most) {
  const nlohmann::ordered_json& value = MemberOf(object, name);
  if (!value.is_number() || !(value.get<double>() >= least && value.get<double>() <= most)) {
    throw BadField(absl::StrCat(name, " is not a number from ", least, " to ", most));
  }
  return value.get<double>();
}

}  // namespace curv
