// SPDX-License-Identifier: Apache-2.0
#include "core/csv.hpp"

#include "scratch.hpp"

#include <CppUTest/TestHarness.h>

using voltlap::plant::CsvTable;

TEST_GROUP(CsvTable) {
  Scratch scratch;
  std::string complaint_of(const std::string& text) {
    const std::string path = scratch.write("table.csv", text);
    return complaint([&] {
      const CsvTable table(path);
      for (std::size_t row = 0; row < table.rows(); ++row) (void)table.number(row, "speed_mps");
    });
  }
};

TEST(CsvTable, ReadsNumbersByColumnAndSkipsCommentLines) {
  const CsvTable table(scratch.write("t.csv", "# said before\na,speed_mps\n1,2.5\n3,-4e1\n"));
  LONGS_EQUAL(2, table.rows());
  DOUBLES_EQUAL(2.5, table.number(0, "speed_mps"), 0.0);
  DOUBLES_EQUAL(-40.0, table.number(1, "speed_mps"), 0.0);
}

TEST(CsvTable, RowWithAnotherNumberOfFieldsIsNamedByFileAndLine) {
  STRCMP_CONTAINS("table.csv:3", complaint_of("a,speed_mps\n1,2\n3\n").c_str());
}

TEST(CsvTable, WordInsteadOfNumberIsNamedByFileAndLine) {
  const std::string message = complaint_of("a,speed_mps\n1,2\n3,fast\n");
  STRCMP_CONTAINS("table.csv:3", message.c_str());
  STRCMP_CONTAINS("fast", message.c_str());
}

TEST(CsvTable, NumberThatIsNotFiniteIsRefused) {
  STRCMP_CONTAINS("table.csv:2", complaint_of("a,speed_mps\n1,nan\n").c_str());
  STRCMP_CONTAINS("table.csv:2", complaint_of("a,speed_mps\n1,inf\n").c_str());
}

TEST(CsvTable, MissingColumnIsNamed) { STRCMP_CONTAINS("speed_mps", complaint_of("a,c\n1,2\n").c_str()); }

TEST(CsvTable, MissingFileIsNamed) {
  STRCMP_CONTAINS("absent.csv", complaint([&] { const CsvTable table(scratch.file("absent.csv")); }).c_str());
}

TEST(CsvTable, EmptyFileIsRefused) { CHECK(complaint_of("") != "no error"); }
