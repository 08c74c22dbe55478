// Writes numbers as people read them.
#pragma once

#include <cstdint>
#include <string>

namespace curv {

// Groups digits: "12,345,678".
std::string WithCommas(uint64_t number);
// Writes six digits where they are the number, else as many as tell it from every other one: "0.5", "0.0009765625".
std::string ExactText(double number);
// Writes a number of things: "1 tile", "12,345 tiles".
std::string CountOf(uint64_t number, const char* thing);
// Writes three digits and a prefix: "950", "12.3 k", "4.56 M".
std::string WithPrefix(double number);
// Writes a time as "59 s", "1:05" or "1:00:00".
std::string Clock(double seconds);

}  // namespace curv
