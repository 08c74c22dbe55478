#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "client/io/las/las_frame.h"
#include "client/io/table_file.h"
#include "tests/client/io/las/las_samples.h"
#include "tests/client/io/samples.h"
#include "tests/client/temp_dir.h"

namespace curv {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

template <typename T>
T At(const std::string& bytes, size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}

class WriteLasTest : public ::testing::Test {
 protected:
  PointTable Read(const std::string& path) {
    absl::StatusOr<PointTable> table = LoadTable(path);
    EXPECT_TRUE(table.ok()) << table.status();
    return table.ok() ? *std::move(table) : PointTable();
  }
  // Writes a table as LAS and returns the bytes.
  std::string Write(const PointTable& table) {
    const absl::Status status = SaveTable(table, dir_.File("out.las"));
    EXPECT_TRUE(status.ok()) << status;
    return dir_.Read("out.las");
  }

  const TempDir dir_;
};

// A file whose records hold all that a format can have.
SampleLas FullLas(int format) {
  SampleLas las = SmallLas(format);
  las.records = {{"LASF_Projection", 2112, "PROJCS[...]"},
                 {"LASF_Spec", 4,
                  Descriptor(9, "normal_x") + Descriptor(4, "echo width", 8 | 16, 0.5, 10.0) + Descriptor(7, "id") +
                      Descriptor(23, "old triple") + Descriptor(0, "", 2)}};
  for (size_t i = 0; i < las.points.size(); ++i) {
    las.points[i] += Pack(0.25f) + Pack(static_cast<int16_t>(-7)) + Pack(~uint64_t{0} - i) +
                     Pack(uint16_t{1}, uint16_t{2}, uint16_t{3}) + "ab";
  }
  if (las.minor_version == 4) {
    las.extended_records = {{"someone", 8, std::string(70000, 'e')}, {"LASF_Spec", 65535, "waves"}};
    las.waveforms_in = 2;
  } else if (las.minor_version == 3) {
    las.extended_records = {{"LASF_Spec", 65535, "waves"}};
    las.waveforms_in = 1;
  }
  return las;
}

TEST_F(WriteLasTest, GivesEveryFormatBackByteByByte) {
  for (int format = 0; format <= 10; ++format) {
    SampleLas las = FullLas(format);
    if (las.minor_version == 3) las.waveforms_in = 0;  // the sample's global encoding says that there are none inside
    if (las.minor_version == 3) las.extended_records.clear();
    const std::string in = las.Bytes();
    const std::string out = Write(Read(dir_.Write("in.las", in)));
    ASSERT_EQ(out.size(), in.size()) << format;
    // The records are the same; that of extra bytes is the last, as in the sample. The software and the extremes
    // differ.
    const size_t points_at = At<uint32_t>(in, 96);
    EXPECT_EQ(At<uint32_t>(out, 96), points_at);
    EXPECT_EQ(out.substr(points_at), in.substr(points_at)) << format;
    EXPECT_EQ(out.substr(0, 58), in.substr(0, 58)) << format;
    EXPECT_EQ(out.substr(90, 179 - 90), in.substr(90, 179 - 90)) << format;
    const size_t header = At<uint16_t>(in, 94);
    EXPECT_EQ(out.substr(227, header - 227), in.substr(227, header - 227)) << format;
    EXPECT_EQ(out.substr(header, 54 + 11),
              in.substr(header, 54 + 11).replace(header - header + 22, 32, out.substr(header + 22, 32)));
    EXPECT_EQ(At<double>(out, 179), 1007 * 0.01 + 500000.0);
    EXPECT_EQ(At<double>(out, 187), 1000 * 0.01 + 500000.0);
    EXPECT_EQ(At<double>(out, 211), 50 * 0.001);
  }
}

TEST_F(WriteLasTest, KeepsWaveformsOfVersion13) {
  SampleLas las = FullLas(4);
  std::string in = las.Bytes();
  in[6] = 2;  // waveform packets are within the file
  const PointTable table = Read(dir_.Write("in.las", in));
  ASSERT_EQ(table.las->waveform_record, 1u);
  const std::string out = Write(table);
  EXPECT_EQ(At<uint64_t>(out, 227), out.size() - 60 - 5);
  EXPECT_EQ(out.substr(out.size() - 5), "waves");
}

TEST_F(WriteLasTest, AddsResultsAsExtraBytes) {
  PointTable table = Read(dir_.Write("in.las", FullLas(3).Bytes()));
  table.Set({"mean_curvature", std::vector<float>{0.5f, std::numeric_limits<float>::quiet_NaN()}});
  table.Set({"nx", std::vector<float>{-0.25f, 1.0f}});
  table.Set({"status", std::vector<uint8_t>{1, 3}});
  const std::string bytes = Write(table);
  EXPECT_THAT(bytes, AllOf(HasSubstr("mean_curvature"), HasSubstr("normal_x"), HasSubstr("1: ok, else why")));
  EXPECT_EQ(At<uint16_t>(bytes, 105), 34 + 4 + 2 + 8 + 6 + 2 + 4 + 1);
  const PointTable back = Read(dir_.File("out.las"));
  EXPECT_EQ(back.Find("mean_curvature")->At(0), 0.5);
  EXPECT_TRUE(std::isnan(back.Find("mean_curvature")->At(1)));
  EXPECT_THAT(Values(back, "nx"), ElementsAre(-0.25, 1));
  EXPECT_THAT(Values(back, "status"), ElementsAre(1, 3));
  for (const Column& column : table.columns()) {
    ASSERT_NE(back.Find(column.name), nullptr) << column.name;
    EXPECT_EQ(back.Find(column.name)->kind(), column.kind()) << column.name;
    if (column.name != "mean_curvature") {
      EXPECT_EQ(Values(back, column.name), Values(table, column.name)) << column.name;
    }
  }
  // A second estimate replaces the first, whether it has the same quantities or not.
  EXPECT_EQ(Write(back).size(), bytes.size());
}

TEST_F(WriteLasTest, DropsDescriptionsOfColumnsThatAreGone) {
  PointTable table = Read(dir_.Write("in.las", FullLas(3).Bytes()));
  PointTable fewer;
  fewer.las = table.las;
  for (Column& column : table.Release()) {
    if (column.name != "nx" && column.name != "old triple_1") fewer.Set(std::move(column));
  }
  Write(fewer);
  const PointTable back = Read(dir_.File("out.las"));
  EXPECT_EQ(back.Find("nx"), nullptr);
  EXPECT_THAT(Values(back, "old_triple_0"), ElementsAre(1, 1)) << "the rest of the array stands alone";
  EXPECT_THAT(Values(back, "echo width"), ElementsAre(6.5, 6.5));
}

TEST_F(WriteLasTest, MakesAFileOfAnyTable) {
  PointTable table;
  table.Set({"x", std::vector<double>{4500000.123, 4500000.456, 4500010.0}});
  table.Set({"y", std::vector<float>{0.1f, 0.2f, -0.3f}});
  table.Set({"z", std::vector<int16_t>{-5, 0, 32000}});
  table.Set({"nx", std::vector<float>{0, 0, 1}});
  table.Set({"intensity", std::vector<float>{1, 2, 65535}});
  table.Set({"classification", std::vector<uint8_t>{2, 200, 6}});
  table.Set({"gps_time", std::vector<float>{1.5f, 2.5f, 3.5f}});
  table.Set({"a column whose name takes more than 32 bytes", std::vector<int32_t>{1, 2, 3}});
  table.Set({"a column whose name takes more than 32 bytes too", std::vector<uint32_t>{1, 2, 3}});
  const std::string bytes = Write(table);
  EXPECT_EQ(At<uint8_t>(bytes, 25), 4);
  EXPECT_EQ(At<uint8_t>(bytes, 104), 6);
  EXPECT_EQ(At<uint16_t>(bytes, 6), 16) << "formats from 6 on have well-known text";
  EXPECT_EQ(At<double>(bytes, 131), 0.001);
  EXPECT_EQ(At<double>(bytes, 139), 0.1);
  EXPECT_EQ(At<double>(bytes, 147), 1.0);
  EXPECT_EQ(At<uint64_t>(bytes, 247), 3u);
  EXPECT_EQ(At<uint64_t>(bytes, 255), 3u) << "all are first returns";
  const PointTable back = Read(dir_.File("out.las"));
  EXPECT_EQ(Values(back, "x"), Values(table, "x"));
  EXPECT_EQ(static_cast<float>(back.Find("y")->At(2)), -0.3f);
  EXPECT_EQ(Values(back, "z"), Values(table, "z"));
  for (const char* name : {"nx", "intensity", "classification", "gps_time"}) {
    EXPECT_EQ(Values(back, name), Values(table, name)) << name;
  }
  EXPECT_EQ(back.Find("intensity")->kind(), ScalarKind::kUint16);
  EXPECT_THAT(Values(back, "a_column_whose_name_takes_more_t"), ElementsAre(1, 2, 3));
  EXPECT_THAT(Values(back, "a_column_whose_name_takes_more_2"), ElementsAre(1, 2, 3));
  EXPECT_THAT(Values(back, "number_of_returns"), ElementsAre(1, 1, 1));
}

TEST_F(WriteLasTest, AttributesThatDoNotFitBecomeExtraOnes) {
  PointTable table;
  for (const char* axis : {"x", "y", "z"}) table.Set({axis, std::vector<float>{0, 1}});
  table.Set({"intensity", std::vector<float>{0.5f, 1.0f}});
  table.Set({"classification", std::vector<int32_t>{2, 256}});
  Write(table);
  const PointTable back = Read(dir_.File("out.las"));
  EXPECT_THAT(Values(back, "intensity"), ElementsAre(0, 0));
  EXPECT_THAT(Values(back, "intensity_2"), ElementsAre(0.5, 1.0));
  EXPECT_THAT(Values(back, "classification_2"), ElementsAre(2, 256));
}

TEST_F(WriteLasTest, CutsNamesBetweenLetters) {
  PointTable table;
  for (const char* axis : {"x", "y", "z"}) table.Set({axis, std::vector<float>{0, 1}});
  // 31 bytes, then a letter of two.
  const std::string long_name = std::string(31, 'a') + "\u00f6he";
  table.Set({long_name, std::vector<float>{2, 3}});
  table.Set({"h\u00f6he", std::vector<float>{4, 5}});
  Write(table);
  const PointTable back = Read(dir_.File("out.las"));
  EXPECT_THAT(Values(back, std::string(31, 'a').c_str()), ElementsAre(2, 3));
  EXPECT_THAT(Values(back, "h\u00f6he"), ElementsAre(4, 5));
}

TEST_F(WriteLasTest, ColorsTakeTheFormatThatHasThem) {
  PointTable table = Read(dir_.Write("in.las", SmallLas(0).Bytes()));
  table.Set({"red", std::vector<uint8_t>{0, 255}});
  table.Set({"green", std::vector<uint8_t>{1, 2}});
  table.Set({"blue", std::vector<uint8_t>{128, 3}});
  const std::string bytes = Write(table);
  EXPECT_EQ(At<uint8_t>(bytes, 104), 2);
  const PointTable back = Read(dir_.File("out.las"));
  EXPECT_THAT(Values(back, "red"), ElementsAre(0, 65535));
  EXPECT_THAT(Values(back, "blue"), ElementsAre(128 * 257, 3 * 257));
  EXPECT_EQ(back.las->records.size(), 0u) << "and no extra bytes";
}

TEST_F(WriteLasTest, TakesTheOldFormatsForTheirAngles) {
  PointTable table = Read(dir_.Write("in.las", SmallLas(3).Bytes()));
  table.las = nullptr;  // as if it came from a PLY file that was made of it
  const std::string bytes = Write(table);
  EXPECT_EQ(At<uint8_t>(bytes, 104), 3);
  EXPECT_EQ(At<uint16_t>(bytes, 105), 34);
  const PointTable back = Read(dir_.File("out.las"));
  for (const Column& column : table.columns()) EXPECT_EQ(Values(back, column.name), Values(table, column.name));
}

TEST_F(WriteLasTest, MovesCoordinatesByLessThanTheirExtentOver2To31) {
  for (const double size : {1e-7, 1.0, 1e7}) {
    for (const double origin : {0.0, 0.3, -4.5e6}) {
      PointTable table;
      for (const char* axis : {"x", "y", "z"}) {
        std::vector<double> values;
        for (int i = 0; i < 1000; ++i) values.push_back(origin + size * std::sin(i * 1.7));
        table.Set({axis, values});
      }
      Write(table);
      const PointTable back = Read(dir_.File("out.las"));
      for (size_t i = 0; i < table.size(); ++i) {
        const double moved = std::abs(back.Find("x")->At(i) - table.Find("x")->At(i));
        // Half a step, and what doubles round.
        ASSERT_LE(moved, size * 2 * std::ldexp(1.0, -31) + 4e-16 * std::abs(origin)) << size << " " << origin;
      }
    }
  }
}

TEST_F(WriteLasTest, RefusesWhatLasCannotHold) {
  const auto message = [this](const PointTable& table) {
    return std::string(SaveTable(table, dir_.File("bad.las")).message());
  };
  PointTable table;
  table.Set({"x", std::vector<double>{1, std::numeric_limits<double>::quiet_NaN()}});
  table.Set({"y", std::vector<double>{1, 2}});
  EXPECT_THAT(message(table), HasSubstr("point 1 has x = nan: LAS holds finite coordinates only"));
  table.Set({"x", std::vector<double>{-1e308, 1e308}});
  EXPECT_THAT(message(table), HasSubstr("outside the range of double"));
  table.Set({"x", std::vector<double>{1, 1}});
  EXPECT_THAT(message(table), HasSubstr("there is no column z"));
  table.Set({"z", std::vector<double>{0, 0}});
  for (int i = 0; i < 342; ++i) table.Set({"c" + std::to_string(i), std::vector<uint8_t>{1, 2}});
  EXPECT_THAT(message(table), HasSubstr("342 attributes beyond those of LAS: a file describes at most 341"));
  EXPECT_FALSE(dir_.Has("bad.las"));
}

}  // namespace
}  // namespace curv
