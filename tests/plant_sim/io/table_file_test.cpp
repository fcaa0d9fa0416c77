// SPDX-License-Identifier: Apache-2.0
#include "io/table_file.hpp"

#include <zlib.h>

#include <cmath>

#include "plant_sim/core/scratch.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

namespace {

void write_gzip(const std::string& path, const std::string& text) {
  gzFile out = gzopen(path.c_str(), "wb");
  gzwrite(out, text.data(), static_cast<unsigned>(text.size()));
  gzclose(out);
}

}  // namespace

TEST_GROUP(InputTable) {
  Scratch scratch;
  std::string complaint_of(const std::string& text) {
    const std::string path = scratch.write("table.csv", text);
    return complaint([&] {
      const InputTable table(path);
      for (std::size_t row = 0; row < table.rows(); ++row) (void)table.number(row, "speed_mps");
    });
  }
};

TEST(InputTable, ReadsNumbersByColumnAndSkipsCommentLines) {
  const InputTable table(scratch.write("t.csv", "# said before\na,speed_mps\n1,2.5\n3,-4e1\n"));
  LONGS_EQUAL(2, table.rows());
  DOUBLES_EQUAL(2.5, table.number(0, "speed_mps"), 0.0);
  DOUBLES_EQUAL(-40.0, table.number(1, "speed_mps"), 0.0);
}

TEST(InputTable, WordsAreFreedOfBlanksAndQuotationMarks) {
  const InputTable table(scratch.write("t.csv", "\"type\", n\n \"Left\" ,1\nof two words,2\n,3\n"));
  STRCMP_EQUAL("Left", table.text(0, "type").c_str());
  STRCMP_EQUAL("of two words", table.text(1, "type").c_str());
  STRCMP_EQUAL("", table.text(2, "type").c_str());
}

TEST(InputTable, ByteOrderMarkWindowsLineEndsAndGzipMakeNoDifference) {
  const std::string packed = scratch.file("t.csv.gz");
  write_gzip(packed, "\xEF\xBB\xBF" "a,speed_mps\r\n1,2.5\r\n");
  const InputTable table(packed);
  CHECK(table.has("a"));
  DOUBLES_EQUAL(2.5, table.number(0, "speed_mps"), 0.0);
}

TEST(InputTable, RowWithAnotherNumberOfFieldsIsNamedByFileAndLine) {
  STRCMP_CONTAINS("table.csv:3", complaint_of("a,speed_mps\n1,2\n3\n").c_str());
}

TEST(InputTable, WordInsteadOfNumberIsNamedByFileAndLine) {
  const std::string message = complaint_of("a,speed_mps\n1,2\n3,fast\n");
  STRCMP_CONTAINS("table.csv:3", message.c_str());
  STRCMP_CONTAINS("fast", message.c_str());
}

TEST(InputTable, NumberThatIsNotFiniteIsRefused) {
  STRCMP_CONTAINS("table.csv:2", complaint_of("a,speed_mps\n1,nan\n").c_str());
  STRCMP_CONTAINS("table.csv:2", complaint_of("a,speed_mps\n1,inf\n").c_str());
}

TEST(InputTable, MissingColumnIsNamed) { STRCMP_CONTAINS("speed_mps", complaint_of("a,c\n1,2\n").c_str()); }

TEST(InputTable, MissingFileAndFolderAreNamed) {
  const auto refusal = [&](const std::string& path) { return complaint([&] { const InputTable table(path); }); };
  STRCMP_CONTAINS("absent.csv: found no file that can be opened", refusal(scratch.file("absent.csv")).c_str());
  STRCMP_CONTAINS("found a folder; expected a CSV file", refusal(scratch.file(".")).c_str());
}

TEST(InputTable, EmptyFileIsRefused) { CHECK(complaint_of("") != "no error"); }

TEST_GROUP(MeasuredTable) {
  Scratch scratch;
};

TEST(MeasuredTable, ReadsPlainAndGzippedTablesAlike) {
  const std::string text = "# a comment\nt_s, i_a\n0,1.5\n1,-2\n";
  const std::string plain = scratch.write("a.csv", text), packed = scratch.file("a.csv.gz");
  write_gzip(packed, text);
  for (const std::string& path : {plain, packed}) {
    const MeasuredTable table = read_measured_table(path);
    LONGS_EQUAL(2, table.rows());
    LONGS_EQUAL(1, table.find("i_a"));
    LONGS_EQUAL(-1, table.find("v_v"));
    DOUBLES_EQUAL(-2.0, table.values[1][1], 0.0);
    LONGS_EQUAL(3, table.lines[0]);
  }
}

TEST(MeasuredTable, ByteOrderMarkIsNoPartOfTheFirstColumn) {
  LONGS_EQUAL(0, read_measured_table(scratch.write("a.csv", "\xEF\xBB\xBFt_s,i_a\n0,1\n")).find("t_s"));
}

TEST(MeasuredTable, HoleOrWordIsNoNumber) {
  const MeasuredTable table = read_measured_table(scratch.write("a.csv", "t_s,i_a\n0,\n1,rest\n2,3\n"));
  CHECK(std::isnan(table.values[1][0]));
  CHECK(std::isnan(table.values[1][1]));
  DOUBLES_EQUAL(3.0, table.values[1][2], 0.0);
}

TEST(MeasuredTable, LastLineThatIsCutOffIsLeftOutAndNamed) {
  const MeasuredTable table = read_measured_table(scratch.write("a.csv", "t_s,i_a,v_v\n0,1,2\n1,2"));
  LONGS_EQUAL(1, table.rows());
  STRCMP_CONTAINS("cut off", table.repairs.at(0).c_str());
}

TEST(MeasuredTable, ShortLineInTheMiddleIsRefusedByFileAndLine) {
  const std::string path = scratch.write("a.csv", "t_s,i_a\n0,1\n1\n2,3\n");
  STRCMP_CONTAINS("a.csv:3", complaint([&] { (void)read_measured_table(path); }).c_str());
}

TEST(MeasuredTable, EmptyFileHeaderAloneAndDamagedGzipAreRefused) {
  STRCMP_CONTAINS("empty file", complaint([&] { (void)read_measured_table(scratch.write("a.csv", "")); }).c_str());
  STRCMP_CONTAINS("without rows",
                  complaint([&] { (void)read_measured_table(scratch.write("b.csv", "t_s\n")); }).c_str());
  const std::string damaged =
      scratch.write("c.csv.gz", std::string("\x1f\x8b\x08\x00\x00\x00\x00\x00\x00\x03garbage", 17));
  STRCMP_CONTAINS("damaged", complaint([&] { (void)read_measured_table(damaged); }).c_str());
  STRCMP_CONTAINS("absent.csv", complaint([&] { (void)read_measured_table(scratch.file("absent.csv")); }).c_str());
}
