// SPDX-License-Identifier: Apache-2.0
#include "race/report/time_series_file.hpp"

#include <algorithm>

#include "plant_sim/core/scratch.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(TimeSeriesFile) {
  Scratch scratch;
  VehicleParameters car;
  RunDescription run{.vehicle = "car", .course = "course", .seed = 7};
  std::vector<double> voltages{3.9, 4.0}, temperatures{25.0, 26.0};
  std::vector<std::string> comments, lines;

  void setup() override { car.battery.cells_in_series = 2; }

  void write(double rate_hz, int samples) {
    TimeSeriesFile file(scratch.file("series.csv"), rate_hz, run, car);
    for (int i = 0; i < samples; ++i) {
      TimeSample sample{};
      sample.time_s = 0.1 * i;
      sample.limit_reason = 2;
      sample.cell_voltage_v = &voltages;
      sample.cell_temperature_c = &temperatures;
      file.add(sample);
    }
    file.commit();
    std::ifstream in(scratch.file("series.csv"));
    for (std::string line; std::getline(in, line);) (line[0] == '#' ? comments : lines).push_back(line);
  }
};

TEST(TimeSeriesFile, HeadCarriesSeedAndEveryParameter) {
  write(10.0, 0);
  STRCMP_CONTAINS("seed 7", comments.front().c_str());
  CHECK(std::find(comments.begin(), comments.end(), "# battery.cells_in_series = 2") != comments.end());
}

TEST(TimeSeriesFile, EveryLineHasAsManyFieldsAsThereAreColumns) {
  write(10.0, 3);
  LONGS_EQUAL(4, lines.size());
  const auto commas = [](const std::string& line) { return std::count(line.begin(), line.end(), ','); };
  for (const std::string& line : lines) LONGS_EQUAL(commas(lines[0]), commas(line));
  STRCMP_CONTAINS("cell_2_voltage_v", lines[0].c_str());
  STRCMP_CONTAINS(",cell_voltage,", lines[1].c_str());
}

TEST(TimeSeriesFile, ColumnsAreThereEvenWithoutASample) {
  write(10.0, 0);
  LONGS_EQUAL(1, lines.size());
}

TEST(TimeSeriesFile, LowerRateKeepsEvenlySpacedSamples) {
  write(2.0, 11);
  LONGS_EQUAL(4, lines.size());
  STRCMP_EQUAL("0.50", lines[2].substr(0, 4).c_str());
  STRCMP_EQUAL("1.00", lines[3].substr(0, 4).c_str());
}

TEST(TimeSeriesFile, RateThatIsNoPartOfTenHertzIsRefused) {
  for (const double rate : {3.0, 20.0, 10.001, 0.0, -1.0}) {
    STRCMP_CONTAINS("--rate", complaint([&] { write(rate, 0); }).c_str());
    CHECK(!std::filesystem::exists(scratch.file("series.csv")));
  }
}
