#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/io/archive/zip.h"
#include "client/io/formats.h"
#include "client/io/table_file.h"
#include "tests/client/io/samples.h"
#include "tests/client/temp_dir.h"

namespace curv {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string Npy(const std::string& text, const std::string& array, char major = 1) {
  const std::string length =
      major == 1 ? Pack(static_cast<uint16_t>(text.size())) : Pack(static_cast<uint32_t>(text.size()));
  return std::string("\x93NUMPY") + major + '\0' + length + text + array;
}

std::string Matrix(const std::string& type, const std::string& shape, const std::string& array, bool fortran = false) {
  return Npy("{'descr': '" + type + "', 'fortran_order': " + (fortran ? "True" : "False") + ", 'shape': " + shape +
                 ", }          \n",
             array);
}

std::string Message(const std::string& file) { return std::string(ReadNpy(file).status().message()); }

PointTable Read(const std::string& file) {
  absl::StatusOr<PointTable> table = ReadNpy(file);
  EXPECT_TRUE(table.ok()) << table.status();
  return table.ok() ? *std::move(table) : PointTable();
}

TEST(NpyTest, ReadsPositionsOfEveryTypeAndOrder) {
  const std::string floats = Pack(1.f, 2.f, 3.f, 4.f, 5.f, 6.f);
  const std::string swapped = PackSwapped(1.0, 2.0, 3.0, 4.0, 5.0, 6.0);
  const std::string by_column = Pack(1.0, 4.0, 2.0, 5.0, 3.0, 6.0);
  for (const std::string& file :
       {Matrix("<f4", "(2, 3)", floats), Matrix(">f8", "(2, 3)", swapped), Matrix("<f8", "(2, 3)", by_column, true),
        Matrix("<i8", "(2, 3)", Pack(int64_t{1}, int64_t{2}, int64_t{3}, int64_t{4}, int64_t{5}, int64_t{6})),
        Matrix("|u1", "(2L, 3L)", "\1\2\3\4\5\6"),
        Matrix(">u2", "(2,3)",
               PackSwapped(uint16_t{1}, uint16_t{2}, uint16_t{3}, uint16_t{4}, uint16_t{5}, uint16_t{6})),
        Npy("{\"shape\": (2, 3), 'fortran_order': False, 'descr': '=f4'}", floats, 2)}) {
    const PointTable table = Read(file);
    EXPECT_THAT(Values(table, "x"), ElementsAre(1, 4));
    EXPECT_THAT(Values(table, "y"), ElementsAre(2, 5));
    EXPECT_THAT(Values(table, "z"), ElementsAre(3, 6));
    EXPECT_EQ(table.columns().size(), 3u);
  }
}

TEST(NpyTest, ReadsNormalsAndFurtherColumns) {
  PointTable table = Read(Matrix("<f4", "(1, 7)", Pack(1.f, 2.f, 3.f, 0.f, 0.6f, 0.8f, 7.f)));
  EXPECT_THAT(Values(table, "nz"), ElementsAre(0.8f));
  EXPECT_THAT(Values(table, "column7"), ElementsAre(7));
  table = Read(Matrix("<f4", "(1, 4)", Pack(1.f, 2.f, 3.f, 4.f)));
  EXPECT_THAT(Values(table, "column4"), ElementsAre(4));
}

TEST(NpyTest, TakesNothingElseForNormals) {
  PointTable table = Read(Matrix("<f4", "(1, 6)", Pack(1.f, 2.f, 3.f, 4.f, 5.f, 6.5f)));
  EXPECT_EQ(table.Find("nx"), nullptr);
  EXPECT_THAT(Values(table, "column6"), ElementsAre(6.5));
  EXPECT_THAT(table.notes, ElementsAre(HasSubstr("no normals: the vector of point 0 has the length 9.1")));
  table = Read(Matrix("<f4", "(1, 6)", Pack(1.f, 2.f, 3.f, 255.f, 0.f, 7.f)));
  EXPECT_THAT(Values(table, "red"), ElementsAre(255));
  EXPECT_EQ(table.Find("blue")->kind(), ScalarKind::kUint8);
  table = Read(Matrix("<f4", "(1, 6)", Pack(1.f, 2.f, 3.f, 0.f, 0.f, 0.f)));
  EXPECT_THAT(Values(table, "nx"), ElementsAre(0)) << "a part of a large file may have no other normals";
}

TEST(NpyTest, TellsOfBytesThatFollowTheArray) {
  const PointTable table = Read(Matrix("<f4", "(1, 3)", Pack(1.f, 2.f, 3.f, 4.f)));
  EXPECT_THAT(Values(table, "z"), ElementsAre(3));
  EXPECT_THAT(table.notes, ElementsAre(HasSubstr("left out 4 bytes that follow the array")));
}

TEST(NpyTest, ReadsStructures) {
  const std::string row = Pack(1.0, 2.0, 3.0) + Pack(4.f, 5.f, 6.f) + PackSwapped(int16_t{-7}) + "??" +
                          Pack(uint8_t{1}) + "abc" + Pack(0.5f, 0.25f);
  const PointTable table = Read(Npy(
      "{'descr': [('position', '<f8', (3,)), ('normal', '<f4', (3,)), ('class', '>i2'), ('', '|V2'), ('ok', '|b1'), "
      "(('a title', 'name'), '|S3'), ('uv', '<f4', (2,))], 'fortran_order': False, 'shape': (2,), }\n",
      row + row));
  EXPECT_THAT(Values(table, "y"), ElementsAre(2, 2));
  EXPECT_THAT(Values(table, "nz"), ElementsAre(6, 6));
  EXPECT_THAT(Values(table, "class"), ElementsAre(-7, -7));
  EXPECT_THAT(Values(table, "ok"), ElementsAre(1, 1));
  EXPECT_THAT(Values(table, "uv_1"), ElementsAre(0.25, 0.25));
  EXPECT_THAT(table.notes, ElementsAre(HasSubstr("left out name")));
}

TEST(NpyTest, TellsOfIntegersThatAreNoDoubles) {
  const PointTable table = Read(Matrix("<u8", "(1, 3)", Pack(uint64_t{1}, uint64_t{2}, ~uint64_t{0})));
  EXPECT_THAT(table.notes, ElementsAre(HasSubstr("is rounded")));
}

TEST(NpyTest, RefusesOtherArrays) {
  const std::string three = Pack(1.f, 2.f, 3.f);
  EXPECT_THAT(Message("ply"), HasSubstr("0x93 NUMPY"));
  EXPECT_THAT(Message(Matrix("<f4", "(3,)", three)), HasSubstr("has the shape (3,): expected (N, 3)"));
  EXPECT_THAT(Message(Matrix("<f4", "(3, 100)", std::string(1200, '\0'))), HasSubstr("that of a transposed one"));
  EXPECT_THAT(Message(Matrix("|b1", "(1, 3)", std::string(3, '\1'))), HasSubstr("the array has the type b1"));
  EXPECT_THAT(Message(Matrix("<f4", "(1, 2)", three)), HasSubstr("(1, 2)"));
  EXPECT_THAT(Message(Matrix("<f4", "(1, 3, 1)", three)), HasSubstr("(1, 3, 1)"));
  EXPECT_THAT(Message(Matrix("<c8", "(1, 3)", three + three)), HasSubstr("has the type c8: expected f4, f8"));
  EXPECT_THAT(Message(Matrix("<\xa3"
                             "6",
                             "(1, 3)", three + three)),
              HasSubstr("has the type ?6: expected f4, f8"));
  EXPECT_THAT(Message(Matrix("|O", "(1, 3)", three)), HasSubstr("holds Python objects"));
  EXPECT_THAT(Message(Matrix("<f4", "(2, 3)", three)),
              HasSubstr("the shape is (2, 3), 4 bytes an element, but only 12"));
  EXPECT_THAT(Message(Matrix("<f4", "(4611686018427387904, 3)", three)), HasSubstr("ends too early"));
  EXPECT_THAT(Message(Matrix("<f4", "(9223372036854775807, 3)", three)), HasSubstr("ends too early"));
  EXPECT_THAT(Message(Matrix("<f", "(1, 3)", three)), HasSubstr("type \"<f\" is not known"));
  EXPECT_THAT(Message(Npy("{'descr': '<f4', 'shape': (1, 3)}", three)),
              HasSubstr("lacks descr, fortran_order or shape"));
  EXPECT_THAT(Message(Npy("{'descr': '<f4', 'size': 3}", three)), HasSubstr("unknown key, \"size\""));
  EXPECT_THAT(Message(Npy("{'descr': [('a', [('b', '<f4')])]}", three)), HasSubstr("structure of its own"));
  EXPECT_THAT(Message(Npy("{'descr': ['x']}", three)), HasSubstr("character 11 of the header: expected ( before"));
  EXPECT_THAT(Message(Npy("{}", three, 4)), HasSubstr("version is 4: expected 1 to 3"));
  EXPECT_THAT(Message(Npy("{}", "").replace(8, 2, "\xff\xff")),
              HasSubstr("the header has 65535 bytes, only 2 are left"));
}

TEST(NpyTest, SurvivesTruncationAndDamage) {
  EXPECT_EQ(AcceptedPrefixes(ReadNpy, Matrix("<f4", "(2, 3)", Pack(1.f, 2.f, 3.f, 4.f, 5.f, 6.f))), 0);
  EXPECT_EQ(AcceptedPrefixes(ReadNpy, Npy("{'descr': [('x', '<f4'), ('n', '<f8', (3,))], 'fortran_order': False, "
                                          "'shape': (1,), }\n",
                                          std::string(28, 'x'))),
            0);
}

PointTable Sample() {
  PointTable table;
  table.Set({"x", std::vector<double>{4500000.123456789, -1}});
  table.Set({"y", std::vector<float>{0.1f, 2}});
  table.Set({"z", std::vector<int32_t>{-5, 7}});
  table.Set({"status", std::vector<uint8_t>{1, 200}});
  table.Set({"it's", std::vector<int8_t>{-1, 1}});
  table.Set({"it\\s", std::vector<uint16_t>{65535, 0}});
  return table;
}

TEST(NumpyFilesTest, ComeBack) {
  const TempDir dir;
  const PointTable table = Sample();
  for (const char* name : {"t.npy", "t.npz"}) {
    ASSERT_TRUE(SaveTable(table, dir.File(name)).ok());
    const absl::StatusOr<PointTable> read = LoadTable(dir.File(name));
    ASSERT_TRUE(read.ok()) << read.status();
    ASSERT_EQ(read->columns().size(), table.columns().size());
    for (size_t i = 0; i < table.columns().size(); ++i) {
      const Column &a = table.columns()[i], &b = read->columns()[i];
      EXPECT_EQ(a.kind(), b.kind());
      EXPECT_EQ(Values(table, a.name), Values(*read, b.name)) << a.name;
    }
    EXPECT_EQ(read->columns()[4].name, "it_s");
    EXPECT_EQ(read->columns()[5].name, "it_s_2");
  }
  EXPECT_THAT(dir.Read("t.npy"),
              HasSubstr("[('x', '<f8'), ('y', '<f4'), ('z', '<i4'), ('status', '|u1'), ('it_s', '|i1')"));
}

TEST(NumpyFilesTest, ManyColumnsTakeALongHeader) {
  const TempDir dir;
  PointTable table;
  for (int i = 0; i < 4000; ++i)
    table.Set({"a_column_with_a_name_" + std::to_string(i), std::vector<float>{static_cast<float>(i)}});
  ASSERT_TRUE(SaveTable(table, dir.File("t.npy")).ok());
  const std::string bytes = dir.Read("t.npy");
  EXPECT_EQ(bytes[6], 2);
  EXPECT_EQ((bytes.size() - 4 * 4000) % 64, 0u);
  EXPECT_THAT(Values(*LoadTable(dir.File("t.npy")), "a_column_with_a_name_3999"), ElementsAre(3999));
}

// An archive as numpy.savez makes it, which declares sizes of 64 bits in local headers.
std::string Archive(const std::vector<std::pair<std::string, std::string>>& members) {
  std::string archive, directory;
  for (const auto& [name, bytes] : members) {
    const auto size = static_cast<uint32_t>(bytes.size());
    const std::string extra = Pack(uint16_t{1}, uint16_t{16}) + Pack(uint64_t{size}, uint64_t{size});
    const std::string start = Pack(uint16_t{45}, uint16_t{0}, uint16_t{0}, uint32_t{0}, Crc32(0, bytes));
    const auto at = static_cast<uint32_t>(archive.size());
    archive += "PK\3\4" + start +
               Pack(~0u, ~0u, static_cast<uint16_t>(name.size()), static_cast<uint16_t>(extra.size())) + name + extra +
               bytes;
    directory += "PK\1\2" + Pack(uint16_t{45}) + start + Pack(size, size, static_cast<uint16_t>(name.size())) +
                 std::string(2 + 2 + 2 + 2 + 4, '\0') + Pack(at) + name;
  }
  const auto count = static_cast<uint16_t>(members.size());
  return archive + directory + "PK\5\6" +
         Pack(uint32_t{0}, count, count, static_cast<uint32_t>(directory.size()), static_cast<uint32_t>(archive.size()),
              uint16_t{0});
}

TEST(NpzTest, ReadsArraysOfNumpy) {
  const std::string positions = Matrix("<f8", "(2, 3)", Pack(1.0, 4.0, 2.0, 5.0, 3.0, 6.0), true);
  const std::string archive = Archive({{"k1.npy", Matrix("<f4", "(2,)", Pack(7.f, 8.f))},
                                       {"positions.npy", positions},
                                       {"normals.npy", Matrix("<f4", "(2, 3)", Pack(0.f, 0.f, 1.f, 0.f, 1.f, 0.f))},
                                       {"d1.npy", Matrix("<f4", "(2, 3)", Pack(1.f, 0.f, 0.f, 1.f, 0.f, 0.f))},
                                       {"scale.npy", Matrix("<f8", "()", Pack(1.0))},
                                       {"other.npy", Matrix("<f4", "(1,)", Pack(7.f))},
                                       {"readme", "text"}});
  const absl::StatusOr<PointTable> table = ReadNpz(archive);
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(Values(*table, "y"), ElementsAre(2, 5));
  EXPECT_THAT(Values(*table, "ny"), ElementsAre(0, 1));
  EXPECT_THAT(Values(*table, "d1x"), ElementsAre(1, 1));
  EXPECT_THAT(Values(*table, "k1"), ElementsAre(7, 8));
  EXPECT_THAT(table->notes, ElementsAre(HasSubstr("array scale: its shape is (), there are 2 points"),
                                        HasSubstr("array other: its shape is (1,)"), HasSubstr("member readme")));
}

TEST(NpzTest, ReadsNormalsBesidePositions) {
  const auto read = [](const std::string& shape, const std::string& array) {
    const absl::StatusOr<PointTable> table = ReadNpz(Archive(
        {{"k1.npy", Matrix("<f4", "(1,)", Pack(7.f))}, {"points.npy", Matrix("<f4", "(1, " + shape + ")", array)}}));
    EXPECT_TRUE(table.ok()) << table.status();
    return table.ok() ? *table : PointTable();
  };
  PointTable table = read("6", Pack(1.f, 2.f, 3.f, 0.f, 0.f, 1.f));
  EXPECT_THAT(Values(table, "x"), ElementsAre(1));
  EXPECT_THAT(Values(table, "nz"), ElementsAre(1));
  EXPECT_THAT(Values(table, "k1"), ElementsAre(7));
  table = read("6", Pack(1.f, 2.f, 3.f, 9.f, 8.f, 200.f));
  EXPECT_THAT(Values(table, "blue"), ElementsAre(200));
  table = read("4", Pack(1.f, 2.f, 3.f, 9.f));
  EXPECT_THAT(Values(table, "column4"), ElementsAre(9));
}

TEST(NpzTest, RefusesOtherArchives) {
  const std::string x = Matrix("<f4", "(1,)", Pack(7.f));
  const auto message = [](const std::string& archive) { return std::string(ReadNpz(archive).status().message()); };
  EXPECT_THAT(message("PK"), HasSubstr("no directory at its end"));
  EXPECT_THAT(message(Archive({{"heights.npy", x}})),
              HasSubstr("no positions: expected an array positions, points or xyz, or x, y and z; it has: heights"));
  std::string damaged = Archive({{"x.npy", x}});
  damaged[damaged.find("descr") - 1] = '"';
  EXPECT_THAT(message(damaged), HasSubstr("member x.npy of the archive is damaged"));
  EXPECT_THAT(message(Archive({{"x.npy", "no array"}})), HasSubstr("0x93 NUMPY"));
  EXPECT_THAT(message(Archive({{"points.npy", Matrix("<f2", "(1, 3)", std::string(6, '\0'))}})),
              HasSubstr("the array points has the type f2: expected f4, f8"));
  EXPECT_THAT(message(Archive({{"xyz.npy", Matrix("<f4", "(3, 100)", std::string(1200, '\0'))}})),
              HasSubstr("the array xyz has the shape (3, 100), that of a transposed one"));
}

TEST(NpzTest, SurvivesTruncationAndDamage) {
  const std::string one = Matrix("<f4", "(1,)", Pack(7.f));
  EXPECT_EQ(AcceptedPrefixes(ReadNpz, Archive({{"x.npy", one}, {"y.npy", one}, {"z.npy", one}})), 0);
}

}  // namespace
}  // namespace curv
