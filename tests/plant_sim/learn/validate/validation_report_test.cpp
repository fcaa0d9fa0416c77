// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/validation_report.hpp"

#include "straight_cell.hpp"

#include <regex>

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(ValidationReport) {
  CellParameters cell = StraightCell::cell();
  std::vector<CellLog> logs{StraightCell::record(StraightCell::half())};
  StudyOptions options;
  std::string report() {
    return validation_report(cell, study_validation(cell, logs, options), {"1.0", "command"});
  }
  static std::size_t count(const std::string& text, const std::string& word) {
    std::size_t found = 0;
    for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++found;
    return found;
  }
};

TEST(ValidationReport, SaysTheErrorInASentence) {
  STRCMP_CONTAINS("straight predicts 1 recording within 0.", report().c_str());
  STRCMP_CONTAINS("constant current, temperature not recorded", report().c_str());
}

TEST(ValidationReport, HasTheTablesThatWereAskedFor) {
  CHECK(report().find("Table 7.3") == std::string::npos);
  options.sensitivity = true;
  STRCMP_CONTAINS("Table 7.3", report().c_str());
  STRCMP_CONTAINS("(192.8)", report().c_str());
}

TEST(ValidationReport, FileNamesAreText) {
  logs[0].path = "a<b>.csv";
  const std::string text = report();
  STRCMP_CONTAINS("a&lt;b&gt;.csv", text.c_str());
  CHECK(text.find("a<b>") == std::string::npos);
}

TEST(ValidationReport, LongRecordingKeepsItsLargestError) {
  logs = {StraightCell::record(std::vector<double>(20000, 1.0))};
  logs[0].voltage_v[12345] += 0.25;
  options = {};
  const ValidationStudy study = study_validation(cell, logs, options);
  const std::string text = validation_report(cell, study, {"1.0", "command"});
  CHECK(text.size() < 2'000'000);
  STRCMP_CONTAINS("\"samples\":5030", text.c_str());  // 20120 rows, one of four
  DOUBLES_EQUAL(0.25, study.files[0].max_error_v, 1e-3);
}

TEST(ValidationReport, OfManyRecordingsTheWorstAreDrawn) {
  while (logs.size() < kChartedRecordings + 2) logs.push_back(logs[0]);
  logs[3].path = "worst.csv";
  for (double& v : logs[3].voltage_v) v -= 0.01;
  const std::string text = report();
  LONGS_EQUAL(kChartedRecordings, count(text, "\"has_temperature\""));
  STRCMP_CONTAINS("\"name\":\"worst.csv\"", text.c_str());
  STRCMP_CONTAINS("largest errors", text.c_str());
}

TEST(ValidationReport, LineBeginsAnewBehindAGap) {
  logs = {StraightCell::record(std::vector<double>(20000, 1.0))};
  STRCMP_CONTAINS("\"begins\":[]", report().c_str());
  logs[0].gap[10001] = true;
  STRCMP_CONTAINS("\"begins\":[2501]", report().c_str());  // one of four rows; the last piece before it is short
}

TEST(ValidationReport, WhatHasNoNumberIsSaidInWords) {
  options.sensitivity = true;
  options.pack_cells = 24;
  const std::string text = report();
  const std::string body = text.substr(text.find("<main>"), text.find("</main>") - text.find("<main>"));
  CHECK(body.size() > 1000);
  CHECK_FALSE(std::regex_search(body, std::regex("[0-9]e[-+][0-9]|[^a-z](nan|inf)[^a-z]")));
}
