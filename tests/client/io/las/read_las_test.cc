#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "client/io/formats.h"
#include "client/io/las/las_frame.h"
#include "client/io/las/laz_points.h"
#include "tests/client/io/las/las_samples.h"
#include "tests/client/io/samples.h"

namespace curv {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string Message(const std::string& file) { return std::string(ReadLas(file).status().message()); }

// The file with the bytes of a scalar replaced.
template <typename T>
std::string With(std::string file, size_t at, T value) {
  file.replace(at, sizeof(T), Pack(value));
  return file;
}

TEST(ReadLasTest, ReadsEveryFormat) {
  for (int format = 0; format <= 10; ++format) {
    const absl::StatusOr<PointTable> table = ReadLas(SmallLas(format).Bytes());
    ASSERT_TRUE(table.ok()) << format << ": " << table.status();
    EXPECT_THAT(Values(*table, "x"), ElementsAre(1000 * 0.01 + 500000.0, 1007 * 0.01 + 500000.0)) << format;
    EXPECT_THAT(Values(*table, "y"), ElementsAre(-2000 * 0.01 + 4500000.0, -1999 * 0.01 + 4500000.0));
    EXPECT_THAT(Values(*table, "z"), ElementsAre(0, 50 * 0.001));
    EXPECT_EQ(table->Find("x")->kind(), ScalarKind::kFloat64);
    EXPECT_THAT(Values(*table, "intensity"), ElementsAre(40000, 40001)) << format;
    EXPECT_THAT(Values(*table, "return_number"), ElementsAre(2, 2)) << format;
    EXPECT_THAT(Values(*table, "number_of_returns"), ElementsAre(3, 3));
    EXPECT_THAT(Values(*table, "scan_direction_flag"), ElementsAre(1, 1)) << format;
    EXPECT_THAT(Values(*table, "edge_of_flight_line"), ElementsAre(0, 0));
    EXPECT_THAT(Values(*table, "classification"), ElementsAre(2, 3)) << format;
    EXPECT_THAT(Values(*table, "synthetic"), ElementsAre(0, 0));
    EXPECT_THAT(Values(*table, "key_point"), ElementsAre(1, 1)) << format;
    EXPECT_THAT(Values(*table, "withheld"), ElementsAre(0, 0));
    EXPECT_THAT(Values(*table, format < 6 ? "scan_angle_rank" : "scan_angle"), ElementsAre(-30, -29)) << format;
    EXPECT_THAT(Values(*table, "user_data"), ElementsAre(77, 77));
    EXPECT_THAT(Values(*table, "point_source_id"), ElementsAre(600, 601)) << format;
    EXPECT_THAT(table->notes, IsEmpty());
  }
}

TEST(ReadLasTest, ReadsWhatSomeFormatsHave) {
  for (int format = 0; format <= 10; ++format) {
    const absl::StatusOr<PointTable> table = ReadLas(SmallLas(format).Bytes());
    ASSERT_TRUE(table.ok()) << table.status();
    const bool time = format == 1 || format >= 3;
    EXPECT_EQ(Values(*table, "gps_time"), time ? std::vector({1.25e8, 1.25e8 + 0.125}) : std::vector<double>());
    const bool colors = format == 2 || format == 3 || format == 5 || format == 7 || format == 8 || format == 10;
    EXPECT_EQ(Values(*table, "green"), colors ? std::vector({65535.0, 65535.0}) : std::vector<double>()) << format;
    EXPECT_EQ(Values(*table, "blue"), colors ? std::vector({10.0, 11.0}) : std::vector<double>());
    const bool infrared = format == 8 || format == 10;
    EXPECT_EQ(Values(*table, "nir"), infrared ? std::vector({30000.0, 30001.0}) : std::vector<double>()) << format;
    const bool waveforms = format == 4 || format == 5 || format >= 9;
    EXPECT_EQ(Values(*table, "wave_offset"),
              waveforms ? std::vector({60.0, std::ldexp(1.0, 40) + 60}) : std::vector<double>())
        << format;
    EXPECT_EQ(Values(*table, "wave_y_t"), waveforms ? std::vector({-0.5, -0.5}) : std::vector<double>());
    EXPECT_EQ(table->Find("overlap") != nullptr, format >= 6);
    EXPECT_EQ(Values(*table, "scanner_channel"), format >= 6 ? std::vector({2.0, 2.0}) : std::vector<double>());
  }
}

TEST(ReadLasTest, ReadsExtraBytes) {
  SampleLas las = SmallLas(6);
  las.records = {{"LASF_Spec", 4,
                  Descriptor(9, "normal_x") + Descriptor(9, "normal_y") + Descriptor(9, "normal_z") +
                      Descriptor(4, "echo width", 8 | 16, 0.5, 10.0) + Descriptor(8, "id") + Descriptor(0, "", 2) +
                      Descriptor(23, "old triple")}};
  for (int i = 0; i < 2; ++i) {
    las.points[static_cast<size_t>(i)] =
        SamplePoint(6, i,
                    Pack(0.0f, 0.6f, -0.8f, static_cast<int16_t>(-4 + i)) +
                        Pack(i == 0 ? int64_t{-5} : std::numeric_limits<int64_t>::max()) +
                        Pack(uint8_t{8}, uint8_t{9}) + Pack(uint16_t{1}, uint16_t{2}, uint16_t{3}) + Pack(uint8_t{66}));
  }
  const absl::StatusOr<PointTable> table = ReadLas(las.Bytes());
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(Values(*table, "ny"), ElementsAre(0.6f, 0.6f));
  EXPECT_THAT(Values(*table, "nz"), ElementsAre(-0.8f, -0.8f));
  EXPECT_THAT(Values(*table, "echo width"), ElementsAre(8.0, 8.5));
  EXPECT_THAT(Values(*table, "id_low"), ElementsAre(4294967291.0, 4294967295.0)) << "2^63 - 1 is no double";
  EXPECT_THAT(Values(*table, "id_high"), ElementsAre(4294967295.0, 2147483647.0));
  EXPECT_THAT(Values(*table, "undocumented"), ElementsAre(8, 8));
  EXPECT_THAT(Values(*table, "undocumented_2"), ElementsAre(9, 9));
  EXPECT_THAT(Values(*table, "old triple_2"), ElementsAre(3, 3));
  EXPECT_THAT(Values(*table, "undocumented_3"), ElementsAre(66, 66)) << "the byte that nothing describes";
}

TEST(ReadLasTest, ReadsNoDataAsNaN) {
  SampleLas las = SmallLas(0);
  std::string descriptor = Descriptor(3, "height", 1 | 8, 0.1);
  descriptor.replace(40, 8, Pack(uint64_t{65535}));
  las.records = {{"LASF_Spec", 4, descriptor}};
  las.points = {SamplePoint(0, 0, Pack(uint16_t{65535})), SamplePoint(0, 1, Pack(uint16_t{30}))};
  const absl::StatusOr<PointTable> table = ReadLas(las.Bytes());
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_TRUE(std::isnan(table->Find("height")->At(0)));
  EXPECT_EQ(table->Find("height")->At(1), 30 * 0.1);
}

TEST(ReadLasTest, KeepsBytesWhoseDescriptionIsWrong) {
  SampleLas las = SmallLas(0);
  for (std::string& point : las.points) point += "abc";
  las.records = {{"LASF_Spec", 4, Descriptor(9, "too long")}};
  absl::StatusOr<PointTable> table = ReadLas(las.Bytes());
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(Values(*table, "undocumented_3"), ElementsAre('c', 'c'));
  EXPECT_THAT(table->notes, ElementsAre(HasSubstr("more than the 3 bytes")));

  las.records = {{"LASF_Spec", 4, Descriptor(1, "a") + Descriptor(99, "future") + Descriptor(1, "b")}};
  table = ReadLas(las.Bytes());
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(Values(*table, "a"), ElementsAre('a', 'a'));
  EXPECT_THAT(Values(*table, "undocumented_2"), ElementsAre('c', 'c'));
  EXPECT_THAT(table->notes, ElementsAre(HasSubstr("data type 99")));

  las.records = {{"LASF_Spec", 4, Descriptor(3, "depth", 8, 0.0)}};
  table = ReadLas(las.Bytes());
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(Values(*table, "depth"), ElementsAre('a' + 256 * 'b', 'a' + 256 * 'b'));
  EXPECT_THAT(table->notes, ElementsAre(HasSubstr("its scale is 0")));
}

TEST(ReadLasTest, KeepsRecordsAndHeader) {
  SampleLas las = SmallLas(9);
  las.records = {{"LASF_Projection", 2112, "PROJCS[...]"}, {"someone", 7, std::string(65535, 'v')}};
  las.extended_records = {{"someone", 8, std::string(70000, 'e')}, {"LASF_Spec", 65535, "waves"}};
  las.waveforms_in = 2;
  const absl::StatusOr<PointTable> table = ReadLas(las.Bytes());
  ASSERT_TRUE(table.ok()) << table.status();
  const LasFrame& frame = *table->las;
  ASSERT_EQ(frame.records.size(), 4u);
  EXPECT_TRUE(frame.records[0].Is("LASF_Projection", 2112));
  EXPECT_EQ(frame.records[1].payload, las.records[1].payload);
  EXPECT_EQ(frame.records[2].payload, las.extended_records[0].payload);
  EXPECT_TRUE(frame.records[3].extended);
  EXPECT_EQ(frame.waveform_record, 3u);
  EXPECT_EQ(frame.project_id, "sixteen bytes id");
  EXPECT_EQ(frame.global_encoding, 17);
}

TEST(ReadLasTest, TellsWhatIsOdd) {
  SampleLas las = SmallLas(0);
  las.points[1][15] = static_cast<char>(0x82);
  EXPECT_THAT(ReadLas(las.Bytes())->notes, ElementsAre(HasSubstr("1 points are marked as withheld")));
  EXPECT_THAT(ReadLas(SmallLas(0).Bytes() + "tail")->notes, ElementsAre("left out 4 bytes at the end of the file"));
  las = SmallLas(0);
  las.offset[1] = 1e15;
  EXPECT_THAT(ReadLas(las.Bytes())->notes, ElementsAre(HasSubstr("coordinates are rounded")));
  las = SmallLas(0);
  las.records = {{"LASF_Projection", 2112, " geogcs[\"WGS 84\"]"}};
  EXPECT_THAT(ReadLas(las.Bytes())->notes, ElementsAre(HasSubstr("longitude and latitude")));
  const std::string keys =
      Pack(uint16_t{1}, uint16_t{1}, uint16_t{0}, uint16_t{1}, uint16_t{1024}, uint16_t{0}, uint16_t{1});
  las.records = {{"LASF_Projection", 34735, keys + Pack(uint16_t{2})}};
  EXPECT_THAT(ReadLas(las.Bytes())->notes, Contains(HasSubstr("longitude and latitude")));
  las.records = {{"LASF_Projection", 34735, keys + Pack(uint16_t{1})}};
  EXPECT_THAT(ReadLas(las.Bytes())->notes, IsEmpty());
}

TEST(ReadLasTest, NamesTheRemedyForCompressedPoints) {
  if (CanReadLaz()) GTEST_SKIP() << "built with lazperf";
  const std::string laz = With(SmallLas(0).Bytes(), 104, uint8_t{128});
  EXPECT_THAT(Message(laz), AllOf(HasSubstr("(LAZ;"), HasSubstr("is 128"), HasSubstr("laszip -i"), HasSubstr("pdal")));
  SampleLas copc = SmallLas(7);
  copc.records = {{"copc", 1, std::string(160, '\0')}};
  EXPECT_THAT(Message(With(copc.Bytes(), 104, uint8_t{128 + 7})), AllOf(HasSubstr("COPC"), HasSubstr("laszip -i")));
}

TEST(ReadLasTest, NamesTheRemedyForE57) {
  EXPECT_THAT(std::string(ReadE57("ASTM-E57...").status().message()), HasSubstr("pdal translate in.e57"));
  EXPECT_THAT(std::string(ReadE57("ply").status().message()), HasSubstr("no E57 file"));
}

TEST(ReadLasTest, RefusesWrongHeaders) {
  const std::string good = SmallLas(3).Bytes();  // 227 bytes of header, two points of 34
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(Message(""), HasSubstr("signature of the file is \"\""));
  EXPECT_THAT(Message("LASX" + good.substr(4)), HasSubstr("\"LASX\": a LAS file starts with \"LASF\""));
  EXPECT_THAT(Message(good.substr(0, 226)), HasSubstr("ends after 226 bytes: the header of a LAS file has 227"));
  EXPECT_THAT(Message(With(good, 24, uint8_t{2})), HasSubstr("version is 2.2: expected LAS 1.0 to 1.4"));
  EXPECT_THAT(Message(With(good, 25, uint8_t{5})), HasSubstr("version is 1.5"));
  EXPECT_THAT(Message(With(good, 104, uint8_t{11})), HasSubstr("format is 11: expected 0 to 10"));
  EXPECT_THAT(Message(With(good, 94, uint16_t{200})), HasSubstr("header size is 200: expected at least 227"));
  EXPECT_THAT(Message(With(good, 94, uint16_t{60000})), HasSubstr("at most 295, the size of the file"));
  EXPECT_THAT(Message(With(good, 96, 226u)), HasSubstr("offset to point data is 226: expected at least 227"));
  EXPECT_THAT(Message(With(good, 96, 5000u)),
              HasSubstr("5000: expected at least 227, the size of the header, and at most 295"));
  EXPECT_THAT(Message(With(good, 105, uint16_t{33})), HasSubstr("record length is 33: points of format 3 take 34"));
  EXPECT_THAT(Message(With(good, 107, 3u)),
              HasSubstr("number of point records is 3, 34 bytes each, but only 68 bytes follow"));
  EXPECT_THAT(Message(With(good, 107, 4294967295u)), HasSubstr("is 4294967295, 34 bytes each"));
  EXPECT_THAT(Message(With(good, 131, 0.0)), HasSubstr("X scale factor is 0: expected a finite number above 0"));
  EXPECT_THAT(Message(With(good, 139, kNaN)), HasSubstr("Y scale factor is nan"));
  EXPECT_THAT(Message(With(good, 147, -0.01)), HasSubstr("Z scale factor is -0.01"));
  EXPECT_THAT(Message(With(good, 163, kNaN)), HasSubstr("Y offset is nan: expected a finite number"));
  EXPECT_THAT(Message(With(good, 131, 1e300)), HasSubstr("leave the range of double"));
}

TEST(ReadLasTest, RefusesWrongRecords) {
  SampleLas las = SmallLas(0);
  las.records = {{"someone", 7, "12345"}};
  const std::string good = las.Bytes();
  EXPECT_THAT(Message(With(good, 100, 2u)), HasSubstr("number of variable length records is 2, 54 bytes or more each, "
                                                      "but only 59 bytes are left"));
  EXPECT_THAT(Message(With(good, 100, 4294967295u)), HasSubstr("is 4294967295"));
  EXPECT_THAT(Message(With(good, 227 + 20, uint16_t{6})),
              HasSubstr("record 0 (someone 7) has the record length after header 6: only 5 bytes are left"));
}

TEST(ReadLasTest, RefusesWrongExtendedRecords) {
  SampleLas las = SmallLas(6);
  las.extended_records = {{"someone", 8, "12345"}};
  const std::string good = las.Bytes();  // 375 bytes of header, two points of 30
  EXPECT_TRUE(ReadLas(good).ok());
  EXPECT_THAT(Message(With(good, 235, uint64_t{434})),
              HasSubstr("is 434: expected at least 435, where the points end"));
  EXPECT_THAT(Message(With(good, 235, ~uint64_t{0})), HasSubstr("at most 500, the size of the file"));
  EXPECT_THAT(Message(With(good, 243, 2u)), HasSubstr("extended variable length records is 2, 60 bytes or more each"));
  EXPECT_THAT(Message(With(good, 435 + 20, ~uint64_t{0})), HasSubstr("(someone 8) has the record length after header "
                                                                     "18446744073709551615: only 5 bytes"));
  EXPECT_THAT(Message(With(good, 247, uint64_t{1} << 62)), HasSubstr("records is 4611686018427387904, 30 bytes each"));
  EXPECT_THAT(Message(With(good, 107, 1u)), HasSubstr("legacy number of point records is 1, the number of point "
                                                      "records 2: expected 0 or the same"));
}

TEST(ReadLasTest, SurvivesTruncationAndDamage) {
  for (const int format : {0, 3, 6, 7, 10}) {
    SampleLas las = SmallLas(format);
    las.records = {{"LASF_Spec", 4, Descriptor(9, "normal_x") + Descriptor(3, "w", 9, 0.5) + Descriptor(0, "", 1)}};
    for (std::string& point : las.points) point += Pack(0.5f, uint16_t{3}) + "?";
    if (format >= 6) las.extended_records = {{"someone", 8, "12345"}};
    EXPECT_EQ(AcceptedPrefixes(ReadLas, las.Bytes()), 0) << format;
  }
}

}  // namespace
}  // namespace curv
