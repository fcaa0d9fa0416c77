// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <string>

#include "io/table_file.hpp"
#include "plant_sim/core/scratch.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(TableDialect) {
  Scratch scratch;
  MeasuredTable read(const std::string& text) { return read_measured_table(scratch.write("a.csv", text)); }
  std::string refusal(const std::string& text) {
    return complaint([&] {
      const MeasuredTable table = read(text);
      for (const std::string& column : table.columns) (void)table.index_for(column, "current", "a map");
    });
  }
  static bool notes(const MeasuredTable& table, const char* words) {
    for (const std::string& note : table.notes) {
      if (note.find(words) != std::string::npos) return true;
    }
    return false;
  }
};

TEST(TableDialect, SemicolonsWithDecimalCommasAreSaid) {
  const MeasuredTable table = read("t;I;U\n0;-0,05;4,2005\n1;1,5e1;3,9\n");
  DOUBLES_EQUAL(15.0, table.values[1][1], 0.0);
  CHECK(notes(table, "decimal comma") && notes(table, "\";\""));
}

TEST(TableDialect, CommasBetweenFieldsAndWithinQuotesAreToldApart) {
  const MeasuredTable table = read("t,I\n\"0,5\",\"1,25\"\n\"1,5\",\"-2,25\"\n");
  DOUBLES_EQUAL(-2.25, table.values[1][1], 0.0);
  STRCMP_CONTAINS("semicolons", refusal("t,I\n0,5,1,25\n1,5,2,25\n").c_str());
}

TEST(TableDialect, NumberThatMayBeAThousandTimesAnotherIsRefused) {
  STRCMP_CONTAINS("1,234", refusal("t;I\n0;1,234\n1;5,678\n").c_str());
  DOUBLES_EQUAL(1.234, read("t;I\n0;1,234\n1;0,5\n").values[1][0], 0.0);
  DOUBLES_EQUAL(1234.0, read("t;I\n0;1,234\n1;0.5\n").values[1][0], 0.0);
  STRCMP_CONTAINS("3,75", refusal("t;I\n0;1.5\n1;2.5\n2;3,75\n").c_str());
}

TEST(TableDialect, DecimalCommaThatComesLateIsFound) {
  std::string text = "t;I\n";
  for (int k = 0; k < 3000; ++k) text += std::to_string(k) + ";0\n";
  const MeasuredTable table = read(text + "3000;2,5\n");
  DOUBLES_EQUAL(2.5, table.values[1].back(), 0.0);
  CHECK(notes(table, "decimal comma"));
}

TEST(TableDialect, QuotesHoldSeparatorsQuotesAndLineBreaks) {
  const MeasuredTable table = read("\"Time\n(s)\",\"a \"\"b\"\", c\"\n0,1\n1,2\n");
  STRCMP_EQUAL("Time (s)", table.columns[0].c_str());
  STRCMP_EQUAL("a \"b\", c", table.columns[1].c_str());
  STRCMP_CONTAINS("a.csv:2: found a quotation mark", refusal("t,I\n\"0,1\n1,2\n").c_str());
}

TEST(TableDialect, LinesAboveTheNamesUnitsAndCommentsAreTold) {
  const MeasuredTable table =
      read("\"Format\",\"AiM CSV File\"\n\"Sample Rate\",\"20\"\n\"Date\",\"15 June\"\n\n\"Time\",\"Speed\",\"I\"\n"
           "\"sec\",\"km/h\",\"A\"\n\n0.0,10,5\n// paused\n0.05,11,6\n% end\n");
  LONGS_EQUAL(2, table.rows());
  STRCMP_EQUAL("I", table.columns[2].c_str());
  STRCMP_EQUAL("km/h", table.about[1].unit.c_str());
  LONGS_EQUAL(8, table.lines[0]);
  CHECK(notes(table, "3 lines above the names") && notes(table, "names in line 5") && notes(table, "units in line 6"));
}

TEST(TableDialect, NamesInACommentAreTakenWhereThereAreNoOthers) {
  STRCMP_EQUAL("I", read("# made by numpy\n# t I U\n0 1 4\n1 2 4\n").columns[1].c_str());
  STRCMP_EQUAL("U[V]", read("~Name of Test: x\n~Time[h]\tU[V]\tI[A]\n0\t4\t1\n1\t4\t1\n").columns[1].c_str());
  STRCMP_CONTAINS("without a line of 3 names", refusal("0,1,4\n1,2,4\n").c_str());
}

TEST(TableDialect, InnermostRowsOfNestedLevelsAreRead) {
  const MeasuredTable table = read(
      "Cycle,Cap\n,Step,Name\n,,Record,I(mA),U(V)\n1,100\n,1,CC\n,,1,5,3.5\n,,2,6,3.6\n,2,CV\n,,3,7,3.7\n");
  LONGS_EQUAL(3, table.rows());
  DOUBLES_EQUAL(7.0, table.values[static_cast<std::size_t>(table.find("I(mA)"))][2], 0.0);
  CHECK(notes(table, "rows of outer levels"));
}

TEST(TableDialect, LatinOneNamesBecomeUtf8AndUtf16IsRead) {
  STRCMP_EQUAL("T [\xC2\xB0" "C]", read("t,T [\xB0" "C]\n0,25\n1,26\n").columns[1].c_str());
  std::string wide = "\xFF\xFE";
  for (const char c : std::string("t\tI\r\n0\t1.5\r\n")) wide.append({c, '\0'});
  DOUBLES_EQUAL(1.5, read(wide).values[1][0], 0.0);
}

TEST(TableDialect, HolesAreCountedByKind) {
  const MeasuredTable table = read("t,I\n0,\n1,NaN\n2,#DIV/0!\n3,inf\n4,1e400\n5,rest\n6,0x10\n7,1\n");
  const MeasuredColumn::Holes& holes = table.about[1].holes;
  LONGS_EQUAL(1, holes.empty);
  LONGS_EQUAL(2, holes.missing);
  LONGS_EQUAL(2, holes.not_finite);
  LONGS_EQUAL(2, holes.words);
  STRCMP_CONTAINS("such as \"NaN\"", holes.text().c_str());
  for (const double value : table.values[1]) CHECK(!std::isinf(value));
}

TEST(TableDialect, SameNameTwiceIsRefusedOnlyWhereItIsUsed) {
  const MeasuredTable table = read("t,I,x,x\n0,1,2,3\n1,1,2,3\n");
  LONGS_EQUAL(1, table.index_for("I", "current", "a map"));
  const std::string message = complaint([&] { (void)table.index_for("x", "current", "a map"); });
  STRCMP_CONTAINS("column 3 and for column 4", message.c_str());
}

TEST(TableDialect, SeparatorAtTheEndOfEveryRowMakesNoColumn) {
  LONGS_EQUAL(2, read("t;I;\n0;1;\n1;2;\n").columns.size());
  LONGS_EQUAL(2, read("t;I\n0;1;\n1;2;\n").columns.size());
}
