// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <random>

#include "drive_frames.hpp"
#include "io/logs/cell_log.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP_BASE(DriveSign, DriveFrames){};

TEST(DriveSign, SignIsFoundOrKeptAndSaid) {
  RoleMap map = pack_map();
  std::string charge_positive;
  std::string discharge_positive;
  for (int k = 0; k < 3000; ++k) {
    const bool on = k / 500 % 2 == 1;
    charge_positive += pack_frame(1.0 + 0.01 * k, on ? -200 : 0, on ? 980 : 1000, k);
    discharge_positive += pack_frame(1.0 + 0.01 * k, on ? 200 : 0, on ? 980 : 1000, k);
  }
  const DriveLog turned = read(charge_positive, map);
  DOUBLES_EQUAL(20.0, turned.channels.at("current").value[600], 1e-9);
  STRCMP_CONTAINS("discharge is negative", turned.notes.at(0).c_str());
  map.roles["current"].discharge = DischargeSign::kPositive;
  CHECK(read(charge_positive, map).sign_contradicted);
  CHECK_FALSE(read(discharge_positive, map).sign_contradicted);
}

TEST(DriveSign, NoiseOfAConstantCurrentContradictsNoSign) {
  RoleMap map = pack_map();
  map.roles["current"].discharge = DischargeSign::kPositive;
  std::string constant;
  for (int k = 0; k < 3000; ++k) {
    const int together = k / 200 % 2;  // 0.5 % of the current, and the voltage by chance with it
    constant += pack_frame(1.0 + 0.01 * k, 200 + together, 980 + together, k);
  }
  CHECK_FALSE(read(constant, map).sign_contradicted);
}

TEST(DriveSign, PublishedVoltageThatRisesWithTheCurrentIsNamedAndDecidesNoSign) {
  std::string text;
  for (int k = 0; k < 3000; ++k) {
    const bool on = k / 500 % 2 == 1;
    text += pack_frame(1.0 + 0.01 * k, on ? 200 : 0, on ? 1010 : 1000, k);
    text += cell_frame(1.0 + 0.01 * k, 0, on ? 9800 : 10000);
  }
  RoleMap map = pack_map();
  map.roles["bus_voltage"] =
      map_of("bus_voltage = {frame = 0x101, signal = \"V\", dbc = \"a.dbc\"}\n").roles["bus_voltage"];
  const DriveLog log = read(text, map);
  DOUBLES_EQUAL(20.0, log.channels.at("current").value[600], 1e-9);
  STRCMP_CONTAINS("not what is measured", log.notes.at(1).c_str());
}

TEST(DriveSign, TheBatterysOwnVoltageDecidesTheSignAndABusOnlyWithoutIt) {
  // A link that charges while the battery is drawn from rises with the current; the charge that flows empties the
  // battery.
  const auto text = [](int sign) {
    std::string out;
    for (int k = 0; k < 6000; ++k) {
      const bool on = k / 500 % 2 == 1;
      out += pack_frame(1.0 + 0.01 * k, sign * (on ? 200 : 0), (on ? 980 : 1000) - k / 300, k);
      out += cell_frame(1.0 + 0.01 * k, 0, on ? 10000 : 9800);
    }
    return out;
  };
  RoleMap map = pack_map();
  map.roles["bus_voltage"] =
      map_of("bus_voltage = {frame = 0x101, signal = \"V\", dbc = \"a.dbc\"}\n").roles["bus_voltage"];
  for (const int sign : {1, -1}) DOUBLES_EQUAL(20.0, read(text(sign), map).channels.at("current").value[600], 1e-9);
  map.roles["current"].discharge = DischargeSign::kPositive;
  CHECK_FALSE(read(text(1), map).sign_contradicted);
  CHECK(read(text(-1), map).sign_contradicted);
  // Of a bus alone: its own.
  map.roles["current"].discharge = DischargeSign::kAuto;
  map.roles.erase("pack_voltage");
  DOUBLES_EQUAL(-20.0, read(text(1), map).channels.at("current").value[600], 1e-9);
}

TEST(DriveSign, AVoltageThatComesASecondLateTurnsNoSign) {
  // The current changes each second, and the voltage answers to the second before: step by step it rises with it.
  for (const int sign : {1, -1}) {
    std::string text;
    std::mt19937 random(5);
    int now = 0, before = 0;
    double drawn = 0.0;
    for (int k = 0; k < 6000; ++k) {
      if (k % 100 == 0) {
        before = now;
        now = static_cast<int>(random() % 400);
      }
      drawn += now;
      text += pack_frame(1.0 + 0.01 * k, sign * now, 1000 - before / 20 - static_cast<int>(drawn / 3e4), k);
    }
    const RoleMap map = pack_map();
    const DriveLog log = read(text, map);
    double sum = 0.0;
    for (const double value : log.channels.at("current").value) sum += value;
    CHECK(sum > 0.0);
  }
}

TEST(DriveSign, ABusThatIsPrechargedTellsTheSignByItsStepsAlone) {
  // It rises for a minute while a little is drawn, then the car drives: over the whole recording it rises with the
  // charge that is drawn, and the published pack voltage with the current.
  RoleMap map = pack_map();
  map.roles["bus_voltage"] =
      map_of("bus_voltage = {frame = 0x101, signal = \"V\", dbc = \"a.dbc\"}\n").roles["bus_voltage"];
  for (const int sign : {1, -1}) {
    std::string text;
    for (int k = 0; k < 9000; ++k) {
      const bool driven = k >= 6000, on = driven && k / 250 % 2 == 1;
      const int bus = driven ? (on ? 9700 : 10000) : k * 10000 / 6000;
      text += pack_frame(1.0 + 0.01 * k, sign * (on ? 200 : 5), on ? 1010 : 1000, k);
      text += cell_frame(1.0 + 0.01 * k, 0, bus);
    }
    DOUBLES_EQUAL(20.0, read(text, map).channels.at("current").value[6300], 1e-9);
  }
}

TEST(DriveSign, WhereAPublishedVoltageRisesWithTheCurrentTheBusIsTheBatterys) {
  std::string text;
  for (int k = 0; k < 3000; ++k) {
    const bool on = k / 500 % 2 == 1;
    text += pack_frame(1.0 + 0.01 * k, on ? 200 : 0, on ? 1010 : 1000, k);
    text += cell_frame(1.0 + 0.01 * k, 0, on ? 35280 : 36000);
  }
  RoleMap map = pack_map();
  map.roles["bus_voltage"] =
      map_of("bus_voltage = {frame = 0x101, signal = \"V\", dbc = \"a.dbc\", scale = 27.7777777778}\n")
          .roles["bus_voltage"];
  LogOptions options;
  options.cells_in_series = 24;
  const CellLog log = cell_log_of(read(text, map), options);
  DOUBLES_EQUAL(20.0, log.current_a[700], 1e-9);
  for (std::size_t row = 600; row < 900; ++row) {
    if (std::isfinite(log.voltage_v[row])) DOUBLES_EQUAL(98.0 / 24.0, log.voltage_v[row], 1e-3);
  }
}
