// Finds what a mistyped word may stand for, for the messages of server and client.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace curvd {

// Letters to put in, take out, replace, or exchange with their neighbor until one word is the other.
size_t EditDistance(std::string_view word, std::string_view other);

// The nearest of `known`, the first of several; "" if none is within two letters, or a third of the letters of `word`
// if that is more.
std::string NearestWord(std::string_view word, const std::vector<std::string>& known);

// "; did you mean NEAREST?", or "" if none is near.
std::string DidYouMean(std::string_view word, const std::vector<std::string>& known);

}  // namespace curvd
