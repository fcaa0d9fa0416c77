// SPDX-License-Identifier: Apache-2.0
#include "race/report/endurance_report.hpp"

#include <nlohmann/json.hpp>

#include <sstream>

#include "plant_sim/core/scratch.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(HtmlReport) {
  Scratch scratch;
  std::vector<double> voltages{3.9, 3.8}, temperatures{25.0, 26.0};
  ReportedRun reported{
      .run = {.vehicle = "car <1>", .course = "ring", .lap_start = "flying", .cells = "all", .seed = 7, .laps = 2},
      .car = {},
      .track = Track{"ring", {{100.0, 0.0}}},
      .result = {},
      .hash = {"trace-hash", "p", "b", "m"},
      .wall_s = 1.0};

  void setup() override {
    reported.result.finished = true;
    reported.result.extreme_times.battery_temp_s = 20.0;
    reported.result.total_time_s = 20.0;
    reported.result.lap_rows = {{1, 11.0, 0.1, 99.0, 0.0}, {2, 9.0, 0.1, 98.0, 0.0}};
    reported.result.laps = 2;
  }
  std::string page(int samples) {
    HtmlReport report(scratch.file("report.html"));
    for (int i = 0; i < samples; ++i) {
      TimeSample sample{};
      sample.time_s = 0.1 * (i + 1);
      sample.cell_voltage_v = &voltages;
      sample.cell_temperature_c = &temperatures;
      report.add(sample);
    }
    report.finish(reported);
    report.commit();
    std::ostringstream text;
    text << std::ifstream(scratch.file("report.html")).rdbuf();
    return text.str();
  }
  static nlohmann::json data_of(const std::string& text) {
    const std::string open = "id=\"voltlap-data\">";
    const std::size_t from = text.find(open) + open.size();
    return nlohmann::json::parse(text.substr(from, text.find("</script>", from) - from));
  }
};

TEST(HtmlReport, PageCarriesWordsNumbersAndHash) {
  const std::string text = page(3);
  for (const char* words : {"✓ Finished", "car &lt;1&gt; finished 2 laps of ring", "trace-hash", "data-lap=\"2\"",
                            "<noscript>", "vehicle.mass_kg", "battery_r0_heat"}) {
    STRCMP_CONTAINS(words, text.c_str());
  }
}

TEST(HtmlReport, FailureIsShownWithItsCause) {
  reported.result.finished = false;
  reported.result.failure_cause = "pack <empty>";
  const std::string text = page(3);
  STRCMP_CONTAINS("✕ Failed", text.c_str());
  STRCMP_CONTAINS("pack &lt;empty&gt;", text.c_str());
  CHECK(data_of(text)["failure"] == "pack <empty>");
}

TEST(HtmlReport, DataHoldLapsCourseAndTrueExtremes) {
  reported.result.max_battery_current_a = 233.80760365691813;
  reported.result.extreme_times.battery_current_s = 7.123;
  const nlohmann::json data = data_of(page(3));
  DOUBLES_EQUAL(20.0, data["laps"][1]["end_s"].get<double>(), 1e-12);
  DOUBLES_EQUAL(100.0, data["course"]["x_m"].back().get<double>(), 1e-9);
  DOUBLES_EQUAL(233.80760365691813, data["extremes"]["pack_current_a"]["value"].get<double>(), 0.0);
  DOUBLES_EQUAL(7.123, data["extremes"]["pack_current_a"]["time_s"].get<double>(), 0.0);
  LONGS_EQUAL(3, data["samples"].get<int>());
  CHECK(data_of(page(0))["samples"] == 0);
}

TEST(HtmlReport, ANameThatIsNoUtf8StopsNothing) {
  reported.run.course = "ring\xff";
  CHECK(data_of(page(1))["course_name"].get<std::string>().starts_with("ring"));
}

TEST(HtmlReport, RecordedDriveHasNoCourse) {
  reported.track.reset();
  CHECK(data_of(page(1))["course"].is_null());
}

TEST(HtmlReport, LongRunIsThinnedEvenlyAndSaysSo) {
  const nlohmann::json data = data_of(page(90'000));
  LONGS_EQUAL(22'500, data["samples"].get<int>());
  DOUBLES_EQUAL(0.4, data["period_s"].get<double>(), 1e-12);
  DOUBLES_EQUAL(0.1, data["first_s"].get<double>(), 1e-12);
}

TEST(HtmlReport, FileIsThereOnlyWhenFinished) {
  { const HtmlReport report(scratch.file("report.html")); }
  LONGS_EQUAL(0, scratch.files());
  STRCMP_CONTAINS("absent",
                  complaint([&] { const HtmlReport report(scratch.file("absent/report.html")); }).c_str());
}
