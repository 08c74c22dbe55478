// Numbers for people.
#pragma once

#include <cstdint>
#include <string>

namespace curv {

// "12,345,678".
std::string WithCommas(uint64_t number);
// "950", "12.3 k", "4.56 M": three digits.
std::string WithPrefix(double number);
// "59 s", "1:05", "1:00:00".
std::string Clock(double seconds);

}  // namespace curv
