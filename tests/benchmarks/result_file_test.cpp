// SPDX-License-Identifier: Apache-2.0
#include "result_file.hpp"

#include "plant_sim/core/scratch.hpp"
#include "quantities.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::benchmarks;

namespace {

Measurement example() {
  Measurement out{.machine = {"a cpu", 2, "unknown", "2600 MHz", "GNU 12", "RelWithDebInfo", "-O2", "0.1.0"},
                  .reference_ns = 250e3,
                  .rows = {{.name = "lap", .operation = "lap solver", .repetitions = 20, .sim_s_per_s = 500'000.0}}};
  out.rows[0].estimate = {.ns = 145e3, .relative = 0.58, .low = 0.58, .high = 0.6, .spread = 0.05};
  return out;
}

}  // namespace

TEST_GROUP(ResultFile) {
  Scratch scratch;
  std::string complaint_of(const std::string& text) {
    const std::string path = scratch.write("m.json", text);
    return complaint([&] { (void)read_json(path); });
  }
  std::string without(const std::string& word, const std::string& instead) {
    std::string text = to_json(example());
    const std::size_t at = text.find(word);
    CHECK(at != std::string::npos);
    return text.replace(at, word.size(), instead);
  }
};

TEST(ResultFile, ReadsWhatItWrites) {
  const Measurement back = read_json(scratch.write("m.json", to_json(example())));
  STRCMP_EQUAL(to_json(example()).c_str(), to_json(back).c_str());
}

TEST(ResultFile, FieldThatIsMissingOrOfAnotherTypeIsNamed) {
  STRCMP_CONTAINS("m.json, lap, ns: found nothing; expected a number",
                  complaint_of(without("\"ns\"", "\"xx\"")).c_str());
  STRCMP_CONTAINS("m.json, lap, relative: found \"x\"",
                  complaint_of(without("\"relative\": 0.58", "\"relative\": \"x\"")).c_str());
  STRCMP_CONTAINS("m.json, lap, relative: found 0",
                  complaint_of(without("\"relative\": 0.58", "\"relative\": 0.0")).c_str());
  STRCMP_CONTAINS("m.json, machine, cpu", complaint_of(without("\"cpu\"", "\"xx\"")).c_str());
  STRCMP_CONTAINS("no \"benchmarks\"", complaint_of(without("\"benchmarks\"", "\"xx\"")).c_str());
}

TEST(ResultFile, WhatIsNoMeasurementIsRefused) {
  STRCMP_CONTAINS("no JSON object", complaint_of("").c_str());
  STRCMP_CONTAINS("no JSON object", complaint_of("[1, 2").c_str());
  STRCMP_CONTAINS("no \"machine\"", complaint_of("{}").c_str());
  STRCMP_CONTAINS("No such file", complaint([&] { (void)read_json(scratch.file("absent")); }).c_str());
  STRCMP_CONTAINS("a folder", complaint([&] { (void)read_json(scratch.file("")); }).c_str());
}

TEST(ResultFile, MarkdownHasARowForEachMeasurement) {
  STRCMP_CONTAINS("| `lap` | lap solver | 145 us | 500 000 |", to_markdown(example()).c_str());
}

TEST_GROUP(Quantities){};

TEST(Quantities, TimesHaveThreeDigitsAndAUnit) {
  STRCMP_EQUAL("1.00 ns", time_text(1.0).c_str());
  STRCMP_EQUAL("999 ns", time_text(999.4).c_str());
  STRCMP_EQUAL("1.00 us", time_text(999.6).c_str());
  STRCMP_EQUAL("10.0 us", time_text(9'999.0).c_str());
  STRCMP_EQUAL("1.38 s", time_text(1.38e9).c_str());
  STRCMP_EQUAL("120 s", time_text(120e9).c_str());
}

TEST(Quantities, FactorsHaveAtMostFourDigitsAndGroupsOfThree) {
  STRCMP_EQUAL("0.50", factor_text(0.5).c_str());
  STRCMP_EQUAL("95", factor_text(95.4).c_str());
  STRCMP_EQUAL("1 465", factor_text(1465.4).c_str());
  STRCMP_EQUAL("2 389 000", factor_text(2'389'123.0).c_str());
}
