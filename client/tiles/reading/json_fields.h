// Reads the JSON of a plan's directory, which may be damaged, or made by someone who wants to do damage.
#pragma once

#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace curv {

// The JSON, or a member, is not what it should be; says which, and why.
class BadField : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Parses an object that is nested as little as ours are. Throws BadField.
nlohmann::ordered_json ParseFields(std::string_view text);

// These return a member, and throw BadField if it lacks, is of another type, or is not in [least, most]. Numbers are
// converted without loss.
const nlohmann::ordered_json& MemberOf(const nlohmann::ordered_json& object, const char* name);
const nlohmann::ordered_json& ArrayOf(const nlohmann::ordered_json& object, const char* name);
std::string TextOf(const nlohmann::ordered_json& object, const char* name);
std::vector<std::string> TextsOf(const nlohmann::ordered_json& object, const char* name);
bool FlagOf(const nlohmann::ordered_json& object, const char* name);
int64_t IntegerOf(const nlohmann::ordered_json& object, const char* name);
uint64_t UnsignedOf(const nlohmann::ordered_json& object, const char* name,
                    uint64_t most = std::numeric_limits<uint64_t>::max());
double NumberOf(const nlohmann::ordered_json& object, const char* name, double least, double most);

}  // namespace curv
