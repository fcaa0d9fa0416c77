// SPDX-License-Identifier: Apache-2.0
#include "io/logs/table_file.hpp"

#include <zlib.h>

#include <cmath>

#include "plant_sim/core/scratch.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(MeasuredTable) {
  Scratch scratch;
};

TEST(MeasuredTable, ReadsPlainAndGzippedTablesAlike) {
  const std::string text = "# a comment\nt_s, i_a\n0,1.5\n1,-2\n";
  const std::string plain = scratch.write("a.csv", text), packed = scratch.file("a.csv.gz");
  gzFile out = gzopen(packed.c_str(), "wb");
  gzwrite(out, text.data(), static_cast<unsigned>(text.size()));
  gzclose(out);
  for (const std::string& path : {plain, packed}) {
    const MeasuredTable table = read_measured_table(path);
    LONGS_EQUAL(2, table.rows());
    LONGS_EQUAL(1, table.find("i_a"));
    LONGS_EQUAL(-1, table.find("v_v"));
    DOUBLES_EQUAL(-2.0, table.values[1][1], 0.0);
    LONGS_EQUAL(3, table.lines[0]);
  }
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
