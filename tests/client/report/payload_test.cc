#include "client/report/payload.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <string>

#include "absl/strings/escaping.h"

namespace curv {
namespace {

std::string Decode(const std::string& text, size_t size) {
  std::string packed, bytes(size + 1, '\0');
  EXPECT_TRUE(absl::Base64Unescape(text, &packed));
  uLongf length = bytes.size();
  EXPECT_EQ(uncompress(reinterpret_cast<Bytef*>(bytes.data()), &length, reinterpret_cast<const Bytef*>(packed.data()),
                       packed.size()),
            Z_OK);
  bytes.resize(length);
  return bytes;
}

TEST(PayloadTest, KeepsArraysInOrderAndSplitsBytes) {
  Payload payload;
  payload.Add("a", std::vector<uint8_t>{1, 2, 255});
  payload.Add("b", std::vector<uint16_t>{0x0102, 0xfffe});
  ASSERT_EQ(payload.arrays().size(), 2u);
  EXPECT_EQ(payload.arrays()[1].name, "b");
  EXPECT_EQ(payload.arrays()[1].count, 2u);
  EXPECT_EQ(payload.arrays()[1].bytes_per_scalar, 2u);
  const auto text = payload.Encode();
  ASSERT_TRUE(text.ok());
  EXPECT_EQ(Decode(*text, 7), std::string("\x01\x02\xff\x02\xfe\x01\xff", 7));
}

}  // namespace
}  // namespace curv
