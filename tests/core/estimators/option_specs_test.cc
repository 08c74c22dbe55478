#include "core/estimators/option_specs.h"

#include <gtest/gtest.h>

#include <set>

namespace curvd {
namespace {

TEST(OptionSpecsTest, DefaultsAreInRangeAndNamesDistinct) {
  std::set<std::string_view> names;
  for (const OptionSpec& spec : OptionSpecs()) {
    EXPECT_TRUE(spec.InRange({})) << spec.name;
    EXPECT_TRUE(names.insert(spec.name).second) << spec.name;
    EXPECT_FALSE(spec.doc.empty()) << spec.name;
  }
}

TEST(OptionSpecsTest, BoundsAreIncludedAndWhatIsBeyondIsNot) {
  for (const OptionSpec& spec : OptionSpecs()) {
    if (const auto* member = std::get_if<uint32_t EstimatorOptions::*>(&spec.member)) {
      EstimatorOptions options;
      for (const double bound : {spec.least, spec.most}) {
        options.** member = static_cast<uint32_t>(bound);
        EXPECT_TRUE(spec.InRange(options)) << spec.name;
      }
      options.** member = static_cast<uint32_t>(spec.most) + 1;
      EXPECT_FALSE(spec.InRange(options)) << spec.name;
      EXPECT_EQ(spec.ValueText(options), std::to_string(static_cast<uint32_t>(spec.most) + 1));
    }
  }
}

}  // namespace
}  // namespace curvd
