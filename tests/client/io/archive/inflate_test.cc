#include "client/io/archive/inflate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include "absl/strings/str_cat.h"
#include "client/io/archive/zip.h"

namespace curv {
namespace {

using ::testing::HasSubstr;

std::string Packed(const std::string& plain, int window) {
  z_stream stream{};
  EXPECT_EQ(deflateInit2(&stream, 9, Z_DEFLATED, window, 8, Z_DEFAULT_STRATEGY), Z_OK);
  std::string packed(plain.size() + 1000, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(plain.data()));
  stream.avail_in = static_cast<uInt>(plain.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  return packed;
}

TEST(InflateTest, UnpacksWhatWasPacked) {
  for (const std::string& plain : {std::string(), std::string("abc"), std::string(5'000'000, 'a')}) {
    EXPECT_EQ(*InflateRaw(Packed(plain, -15), plain.size()), plain);
    const std::string gz = Packed(plain, 31);
    EXPECT_TRUE(IsGzip(gz));
    EXPECT_EQ(*Gunzip(gz, plain.size()), plain);
    EXPECT_EQ(*Gunzip(gz + gz, 2 * plain.size()), plain + plain) << "members follow each other";
  }
}

TEST(InflateTest, RefusesDamage) {
  const std::string plain = "a text that is not all the same", packed = Packed(plain, -15);
  EXPECT_THAT(std::string(InflateRaw(packed, plain.size() - 1).status().message()),
              HasSubstr("gives 30 or more of 30"));
  EXPECT_THAT(std::string(InflateRaw(packed, plain.size() + 1).status().message()), HasSubstr("gives 31 of 32"));
  EXPECT_THAT(std::string(InflateRaw(packed, 1'000'000'000).status().message()), HasSubstr("cannot hold them"));
  const std::string gz = Packed(plain, 31);
  for (size_t size = 0; size < gz.size(); ++size) EXPECT_FALSE(Gunzip(gz.substr(0, size), 1000).ok()) << size;
  EXPECT_EQ(*Gunzip(gz + std::string(512, '\0'), 1000), plain) << "zeros fill up a block";
  EXPECT_THAT(std::string(Gunzip(gz + "junk", 1000).status().message()),
              HasSubstr("4 bytes that are not gzip data follow its end"));
  std::string damaged = gz;
  damaged[gz.size() - 6] ^= 1;  // in the sum
  EXPECT_THAT(std::string(Gunzip(damaged, 1000).status().message()), HasSubstr("damaged or cut off"));
}

// A few bytes can unpack to more than a machine has.
TEST(InflateTest, StopsAtTheMostBytes) {
  const std::string plain(5'000'000, 'a'), gz = Packed(plain, 31);
  EXPECT_THAT(std::string(Gunzip(gz, plain.size() - 1).status().message()), HasSubstr("to more than 4999999 bytes"));
  EXPECT_THAT(std::string(Gunzip(gz + gz, plain.size()).status().message()), HasSubstr("to more than 5000000 bytes"));
  EXPECT_THAT(std::string(Gunzip(gz, 0).status().message()), HasSubstr("to more than 0 bytes"));
}

}  // namespace
}  // namespace curv
