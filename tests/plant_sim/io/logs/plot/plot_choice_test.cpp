// SPDX-License-Identifier: Apache-2.0
#include "io/logs/plot/plot_choice.hpp"

#include <algorithm>
#include <cmath>

#include "courses.hpp"
#include "io/logs/plot/signal_unit.hpp"
#include "plant_sim/core/scratch.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

std::vector<double> wave(double size, int count = 500) {
  std::vector<double> out;
  for (int i = 0; i < count; ++i) out.push_back(std::round(size * std::sin(0.03 * i)));
  return out;
}

std::vector<double> counter() {
  std::vector<double> out;
  for (int i = 0; i < 500; ++i) out.push_back(i % 16);
  return out;
}

class Heard : public PlottedSignals {
 public:
  void add(const std::string& name, const std::string& unit, const std::vector<double>& values) {
    heads_.push_back({name, unit, "", {}});
    courses.push_back(course_of_values(values));
  }
  void read(const SampleSink&, const ReadProgress&) override {}
  [[nodiscard]] const std::vector<SignalHead>& heads() const override { return heads_; }
  [[nodiscard]] std::vector<std::string> silent() const override { return {"Charger.Voltage"}; }
  [[nodiscard]] const RecordingFacts& facts() const override { return facts_; }
  std::vector<SignalCourse> courses;

 private:
  std::vector<SignalHead> heads_;
  RecordingFacts facts_;
};

}  // namespace

TEST_GROUP(PlotChoice) {
  Heard heard;
  TEST_SETUP() {
    heard.add("Bms.PackVoltage", "V", wave(400));
    heard.add("Bms.PackCurrent", "A", wave(200));
    heard.add("Bms.Counter", "", counter());
    heard.add("can1:Inverter.MotorTemp", "degC", wave(60));
    heard.add("Bms.Serial", "", std::vector<double>(500, 7.0));
    heard.add("Inverter.Quiet", "V", {});
  }
  std::vector<std::string> named(const std::vector<std::string>& patterns) {
    std::vector<std::string> out;
    for (const std::size_t k : signals_named(patterns, heard, heard.courses).signals)
      out.push_back(heard.heads()[k].name);
    return out;
  }
};

TEST(PlotChoice, NamesMayBeWholeShortOrPatterns) {
  CHECK(named({"Bms.PackVoltage"}) == std::vector<std::string>{"Bms.PackVoltage"});
  CHECK(named({"PackVoltage"}) == std::vector<std::string>{"Bms.PackVoltage"});
  CHECK(named({"*temp*"}) == std::vector<std::string>{"can1:Inverter.MotorTemp"});
  CHECK(named({"Inverter.MotorTemp"}) == std::vector<std::string>{"can1:Inverter.MotorTemp"});
  CHECK((named({"Pack*", "PackVoltage"}) == std::vector<std::string>{"Bms.PackVoltage", "Bms.PackCurrent"}));
}

TEST(PlotChoice, ABracketInANameIsNoPattern) {
  heard.add("Speed [front]", "km/h", wave(50));
  CHECK(named({"Speed [front]"}) == std::vector<std::string>{"Speed [front]"});
}

TEST(PlotChoice, ANameThatFitsNothingIsAnsweredWithTheNearest) {
  const std::string told = complaint([&] { named({"PackVolts"}); });
  STRCMP_CONTAINS("--signals PackVolts", told.c_str());
  STRCMP_CONTAINS("Bms.PackVoltage", told.c_str());
}

TEST(PlotChoice, ASignalThatWasNeverHeardIsCalledThat) {
  STRCMP_CONTAINS("never heard", complaint([&] { named({"Charger.Voltage"}); }).c_str());
}

TEST(PlotChoice, MoreThanAPageCanShowIsRefused) {
  for (int k = 0; k < 120; ++k) heard.add("Cells.Cell" + std::to_string(k), "V", wave(4));
  STRCMP_CONTAINS("at most 96", complaint([&] { named({"*Cell*"}); }).c_str());
}

TEST(PlotChoice, WithoutNamesWhatMovesIsTakenAndCountersAndConstantsAreNot) {
  const PlotChoice choice = signals_that_move(heard.heads(), heard.courses);
  CHECK((choice.signals == std::vector<std::size_t>{0, 1, 3}));
  STRCMP_CONTAINS("1 never change", choice.reason.c_str());
  STRCMP_CONTAINS("1 are counters", choice.reason.c_str());
}

TEST(PlotChoice, WithoutNamesNoQuantityTakesAllPlaces) {
  for (int k = 0; k < 200; ++k) heard.add("Cells.Cell" + std::to_string(k), "V", wave(4000));
  const PlotChoice choice = signals_that_move(heard.heads(), heard.courses);
  CHECK(choice.signals.size() <= 24);
  CHECK(std::find(choice.signals.begin(), choice.signals.end(), 1) != choice.signals.end());
  CHECK(std::find(choice.signals.begin(), choice.signals.end(), 3) != choice.signals.end());
}

TEST(PlotChoice, WhereNothingMovesSomethingIsDrawnAllTheSame) {
  Heard still;
  still.add("A.B", "V", std::vector<double>(10, 1.0));
  CHECK_FALSE(signals_that_move(still.heads(), still.courses).signals.empty());
}

TEST_GROUP(SignalUnit){};

TEST(SignalUnit, SpellingsOfOneUnitAreOne) {
  for (const char* spelled : {"degC", "C", "deg C", "°C", "temperature:C", "Celsius"})
    STRCMP_EQUAL("°C", signal_unit(spelled).text.c_str());
  STRCMP_EQUAL("Rotation", signal_unit("angular_speed:rpm").quantity.c_str());
  STRCMP_EQUAL("", signal_unit("gids").quantity.c_str());
  STRCMP_EQUAL("gids", signal_unit("gids").text.c_str());
}
