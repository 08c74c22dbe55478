// Checks and parses the values of flags that several commands share. Errors name flag, value and limit.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "CLI/CLI.hpp"

namespace curv {

// These are checks that CLI11 runs while it parses. FinitePositive accepts a finite number above 0, FiniteNotNegative
// one of 0 or more, UpTo one in [0, most], Whole a whole number in [low, high].
CLI::Validator FinitePositive();
CLI::Validator FiniteNotNegative();
CLI::Validator UpTo(double most);
CLI::Validator Whole(uint64_t low, uint64_t high);
// Transforms a size such as 512MiB, of `least` or more, which is a whole number of MiB, into its bytes.
CLI::Validator ByteSize(uint64_t least);
// Accepts "auto", and the sizes of neighborhoods from 4 to `most`.
CLI::Validator AutoOrCount(uint32_t most);

// Refuses an empty text, which comes from a shell variable that is not set.
CLI::Validator NotEmpty();

// These accept "X,Y,Z", three finite numbers; Direction also x, y, z, -x, -y and -z, and not 0,0,0.
CLI::Validator FiniteVector();
CLI::Validator Direction();

// Has flags without a value, of the program and all of its commands, refuse one that does not say yes or no: CLI11
// takes any text that begins with a number for yes, and `--tiles=20000` then asks for nothing of the kind.
void RefuseValuesOfSwitches(CLI::App& app);

// Parses what FiniteVector, or Direction, accepts. Returns false if `text` is anything else.
bool ParseVector(const std::string& text, std::array<double, 3>& vector);
bool ParseDirection(const std::string& text, std::array<double, 3>& direction);

// Parses "LO:HI" with LO < HI; both and their difference are finite. Returns false if `text` is anything else.
bool ParseRange(const std::string& text, double& low, double& high);
// Parses "WIDTHxHEIGHT", whole numbers in [low, high]. Returns false if `text` is anything else.
bool ParseSize(const std::string& text, int low, int high, int& width, int& height);

}  // namespace curv
