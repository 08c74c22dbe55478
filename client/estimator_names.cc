#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/strings/ascii.h"
#include "client/curvature_client.h"
#include "curvature/v1/curvature.pb.h"

namespace curv {
namespace {

namespace v1 = curvature::v1;

struct NamedEstimator {
  std::string name;
  Estimator estimator;
};

// What people call a value of the contract: its name without the prefix, in small letters, with - for _; two have
// shorter names.
std::string NameOf(std::string value) {
  value = absl::AsciiStrToLower(value.substr(std::string_view("ESTIMATOR_").size()));
  std::replace(value.begin(), value.end(), '_', '-');
  if (value == "jet-fitting") return "jet";
  if (value == "algebraic-shape-operator") return "aso";
  return value;
}

// All estimators of the contract, in its order.
const std::vector<NamedEstimator>& Estimators() {
  static const auto* const estimators = [] {
    auto* all = new std::vector<NamedEstimator>();
    const auto* descriptor = v1::Estimator_descriptor();
    for (int i = 0; i < descriptor->value_count(); ++i) {
      if (descriptor->value(i)->number() == v1::ESTIMATOR_UNSPECIFIED) continue;
      all->push_back({NameOf(descriptor->value(i)->name()), static_cast<Estimator>(descriptor->value(i)->number())});
    }
    return all;
  }();
  return *estimators;
}

constexpr std::pair<NormalMethod, std::string_view> kNormalMethods[] = {{NormalMethod::kPca, "pca"},
                                                                        {NormalMethod::kJet1, "jet-1"},
                                                                        {NormalMethod::kJet2, "jet-2"},
                                                                        {NormalMethod::kJet4, "jet-4"}};

}  // namespace

std::string_view NormalMethodName(NormalMethod method) {
  for (const auto& [value, name] : kNormalMethods) {
    if (value == method) return name;
  }
  return "unknown";  // of a server that is newer
}

std::optional<NormalMethod> NormalMethodOf(std::string_view name) {
  for (const auto& [value, word] : kNormalMethods) {
    if (word == name) return value;
  }
  return std::nullopt;
}

std::span<const std::string_view> EstimatorNames() {
  static const auto* const names = [] {
    auto* all = new std::vector<std::string_view>();
    for (const NamedEstimator& named : Estimators()) all->push_back(named.name);
    return all;
  }();
  return *names;
}

std::string_view EstimatorName(Estimator estimator) {
  const auto found = std::find_if(Estimators().begin(), Estimators().end(),
                                  [&](const NamedEstimator& named) { return named.estimator == estimator; });
  return found == Estimators().end() ? std::string_view() : found->name;
}

std::optional<Estimator> EstimatorOf(std::string_view name) {
  const auto found = std::find_if(Estimators().begin(), Estimators().end(),
                                  [&](const NamedEstimator& named) { return named.name == name; });
  if (found == Estimators().end()) return std::nullopt;
  return found->estimator;
}

}  // namespace curv
