// Reads the JSON of a plan's directory, which may be damaged, or made by someone who wants to do damage.
#pragma once

#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>

namespace curv {

// A member is not what it should be; says which, and why. What nlohmann::json throws derives from std::exception too.
class BadField : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Parses an object that is nested as little as ours are. Throws std::exception.
nlohmann::ordered_json ParseFields(std::string_view text);

// These return a member, and throw std::exception if it lacks, is of another type, or is not in [least, most]. Numbers
// are converted without loss.
uint64_t UnsignedOf(const nlohmann::ordered_json& object, const char* name,
                    uint64_t most = std::numeric_limits<uint64_t>::max());
double NumberOf(const nlohmann::ordered_json& object, const char* name, double least, double most);

}  // namespace curv
