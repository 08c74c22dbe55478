// Kinds of flag values that several commands share. Errors name flag, value and limit.
#pragma once

#include <cstdint>
#include <string>

#include "CLI/CLI.hpp"

namespace curv {

// Checks of a value that CLI11 runs while it parses.
CLI::Validator FinitePositive();
CLI::Validator FiniteNotNegative();
// A whole number in [low, high].
CLI::Validator Whole(uint64_t low, uint64_t high);

// A text with something in it: an empty one comes from a variable that is not set.
CLI::Validator NotEmpty();

// "LO:HI" with finite LO < HI. False if `text` is not that.
bool ParseRange(const std::string& text, double& low, double& high);
// "WIDTHxHEIGHT", whole numbers in [low, high]. False if `text` is not that.
bool ParseSize(const std::string& text, int low, int high, int& width, int& height);

}  // namespace curv
