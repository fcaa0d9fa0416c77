// SPDX-License-Identifier: Apache-2.0
#include "race/sensors/sensor_frames.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

/// A car with the tractive system on, and the frames that its sensors send tick by tick.
struct Bench {
  explicit Bench(const VehicleParameters& parameters) : car(parameters, false, 0.001), frames(car.parameters(), 1) {}

  const TxQueue& tick(std::uint32_t n) {
    tx.clear();
    frames.send(Instant::from_ms(n * can::kTickMs), car, pedals, switches, tx);
    return tx;
  }
  void drive(double seconds, double phase_current_a) {
    for (Contactor* c : {&car.contactors.air_plus, &car.contactors.air_minus}) c->command(true);
    for (int period = 0; period < std::lround(seconds * 100.0); ++period) {
      car.inverter.command(phase_current_a, true);
      for (int i = 0; i < 10; ++i) car.step(0.0);
      car.renew(0.01);
    }
  }
  template <class Message>
  Message first(std::uint32_t at = 0) {
    Message m;
    for (const Frame& f : tick(at)) {
      if (can::decode(f, m)) return m;
    }
    FAIL("the message was not sent");
    return m;
  }

  Car car;
  SensorFrames frames;
  Pedals pedals;
  Switches switches;
  TxQueue tx;
};

VehicleParameters with_cells(int cells) {
  VehicleParameters car = vtm16e();
  car.battery.cells_in_series = cells;
  car.battery.initial_soc = 0.5;
  car.sensors.temperature_count = std::min(36, (cells + 3) / 4);
  return car;
}

}  // namespace

TEST_GROUP(SensorFrames) {
  Bench bench{vtm16e()};
};

TEST(SensorFrames, CarryTheTruthToTheResolutionOfTheWire) {
  bench.drive(2.0, 400.0);
  const auto pack = bench.first<can::PackSensor>();
  CHECK(pack.pack_current_ok && pack.pack_voltage_ok);
  DOUBLES_EQUAL(bench.car.pack_current_a(), pack.pack_current_ma * 1e-3, 0.0006);
  DOUBLES_EQUAL(bench.car.pack().voltage(), pack.pack_voltage_100uv * 1e-4, 0.0051);
  const auto inverter = bench.first<can::InverterStatus>();
  DOUBLES_EQUAL(bench.car.motor_omega_rad_s() * 30.0 / M_PI, inverter.motor_speed_rpm, 0.5);
  DOUBLES_EQUAL(bench.car.dc_link_voltage(), inverter.dc_link_voltage_100uv * 1e-4, 0.0051);
  DOUBLES_EQUAL(400.0, inverter.phase_current_ma * 1e-3, 0.05);
  const auto wheels = bench.first<can::WheelSpeeds>();
  CHECK(wheels.rear_left_ok);
  DOUBLES_EQUAL(bench.car.vehicle().rear_omega() * 0.22225, wheels.rear_left_mmps * 1e-3, 0.0105);
  DOUBLES_EQUAL(bench.car.vehicle().front_omega() * 0.22225, wheels.front_right_mmps * 1e-3, 0.0105);
}

TEST(SensorFrames, EveryCellComesThroughWithATenthOfAMillivolt) {
  bench.drive(1.0, 400.0);
  std::vector<double> seen(24, 0.0);
  for (std::uint32_t n = 0; n < 3; ++n) {
    for (const Frame& f : bench.tick(n)) {
      can::CellVoltages m;
      if (!can::decode(f, m)) continue;
      for (std::size_t i = 0; i < can::CellVoltages::kPerFrame; ++i) {
        CHECK(m.cell_ok[i]);
        seen[m.group * can::CellVoltages::kPerFrame + i] = m.cell_100uv[i] * 1e-4;
      }
    }
  }
  for (std::size_t cell = 0; cell < 24; ++cell) DOUBLES_EQUAL(bench.car.pack().cell_voltage(cell), seen[cell], 5.1e-5);
}

TEST(SensorFrames, PedalsAreTwoSensorsOfDifferentSlopeAndTwoPressures) {
  bench.pedals = {0.25, 0.5};
  const auto m = bench.first<can::Pedals>();
  DOUBLES_EQUAL(1.5, m.apps1_100uv * 1e-4, 0.0011);
  DOUBLES_EQUAL(0.75, m.apps2_100uv * 1e-4, 0.0011);
  DOUBLES_EQUAL(35.0, m.brake_front_mbar * 1e-3, 0.026);
  DOUBLES_EQUAL(35.0, m.brake_rear_mbar * 1e-3, 0.026);
}

TEST(SensorFrames, PedalsPutOutTheVoltagesOfTheGivenSensors) {
  bench.pedals = {0.5, 0.0};
  SensorFrames other(bench.car.parameters(), 1, {.apps1 = {1.0, 4.0}, .apps2 = {0.4, 1.4}});
  TxQueue tx;
  other.send(Instant{}, bench.car, bench.pedals, bench.switches, tx);
  can::Pedals m;
  CHECK(std::any_of(tx.begin(), tx.end(), [&m](const Frame& f) { return can::decode(f, m); }));
  DOUBLES_EQUAL(2.5, m.apps1_100uv * 1e-4, 0.0011);
  DOUBLES_EQUAL(0.9, m.apps2_100uv * 1e-4, 0.0011);
}

TEST(SensorFrames, ContactorsAndSwitchesAreReportedAsTheyAre) {
  bench.switches = {.shutdown_closed = true, .ts_on = false, .ready_to_drive = true, .reset = false};
  bench.car.contactors.air_minus.set_fault(ContactorFault::kWelded);
  const auto m = bench.first<can::VehicleIo>();
  CHECK(m.air_minus_aux && m.shutdown_closed && m.rtd_button);
  CHECK_FALSE(m.air_plus_aux || m.precharge_aux || m.ts_on_button || m.reset_button);
}

TEST(SensorFrames, PositionsBeyondTheLastCellAreInvalidOnTheWire) {
  Bench odd(with_cells(25));
  for (std::uint32_t n = 0; n < 3; ++n) {
    for (const Frame& f : odd.tick(n)) {
      can::CellVoltages m;
      if (can::decode(f, m) && m.group == 8) {
        CHECK(m.cell_ok[0]);
        CHECK_FALSE(m.cell_ok[1] || m.cell_ok[2]);
        return;
      }
    }
  }
  FAIL("group 8 was not sent");
}

TEST(SensorFrames, EverySafetyRelevantFrameIsSealedAndCounts) {
  std::map<std::uint32_t, std::uint8_t> last;
  for (std::uint32_t n = 0; n < 40; ++n) {
    for (const Frame& f : bench.tick(n)) {
      CHECK(codec::sealed_ok(f));
      if (last.count(f.id) != 0) LONGS_EQUAL((last[f.id] + 1) & 0xFF, codec::counter_of(f));
      last[f.id] = codec::counter_of(f);
    }
  }
}

TEST(SensorFrames, CellGroupsComeEvery30MillisecondsUpTo48CellsAndEvery100Above) {
  for (const auto& [cells, period] : {std::pair{24, 3U}, {48, 3U}, {49, 10U}, {144, 10U}}) {
    Bench pack(with_cells(cells));
    std::map<std::uint32_t, std::vector<std::uint32_t>> sent;
    for (std::uint32_t n = 0; n < 60; ++n) {
      for (const Frame& f : pack.tick(n)) {
        can::CellVoltages m;
        if (can::decode(f, m)) sent[m.group].push_back(n);
      }
    }
    LONGS_EQUAL((cells + 2) / 3, sent.size());
    for (const auto& [group, ticks] : sent) {
      for (std::size_t i = 1; i < ticks.size(); ++i) LONGS_EQUAL(period, ticks[i] - ticks[i - 1]);
    }
  }
}

TEST(SensorFrames, TheFullestTickLeavesRoomForTheOtherNodes) {
  // Of the BMS those that it sends on a road; can_dbc/check.py counts all of them as they are due.
  constexpr std::size_t kOnACharger = can::BalancingCommand::kGroups + 2;
  constexpr std::size_t kOfBms = std::size(can::kBmsTx) - kOnACharger;
  constexpr std::size_t kStatus = 1, kCommand = 1, kSetpoints = 4;  // of the master, for one inverter or for four
  for (const int cells : {24, 48, 144}) {
    Bench pack(with_cells(cells));
    VehicleParameters four = with_cells(cells);
    four.powertrain.motors = 4;
    four.inverter.protocol = "amk";
    Bench hubs(four);
    std::size_t fullest = 0, fullest_of_four = 0;
    for (std::uint32_t n = 0; n < 300; ++n) {
      fullest = std::max(fullest, pack.tick(n).size());
      fullest_of_four = std::max(fullest_of_four, hubs.tick(n).size());
    }
    CHECK(fullest + kOfBms + kStatus + kCommand <= 22);
    CHECK(fullest_of_four + kOfBms + kStatus + kSetpoints <= 28);
  }
}

TEST(SensorFrames, FourInvertersTellEachItsOwnMotor) {
  Bench hubs(amk_4wd());
  Car& car = hubs.car;
  car.vehicle().set_speed(12.0);
  std::map<std::size_t, codec::AmkActual1> told;
  std::set<std::uint32_t> ids;
  for (std::uint32_t n = 0; n < 12; ++n) {
    for (const Frame& f : hubs.tick(n)) {
      std::size_t wheel = 0;
      codec::AmkActual1 m;
      if (codec::decode_amk(f, wheel, m)) told[wheel] = m;
      if (codec::is_amk(f.id)) ids.insert(f.id);
      CHECK(f.id != can::InverterStatus::kId && f.id != can::MotorTemperatures::kId);
    }
  }
  LONGS_EQUAL(9, ids.size());
  LONGS_EQUAL(4, told.size());
  for (const auto& [wheel, m] : told) {
    DOUBLES_EQUAL(car.motor_omega_rad_s(car.drives[wheel]) * 30.0 / M_PI, m.actual_velocity_rpm, 20.0);
    CHECK(m.system_ready && !m.error && !m.dc_on);
  }
}

TEST(SensorFrames, ThermistorsAreSpreadOverTheCells) {
  VehicleParameters car = vtm16e();
  car.battery.cells.resize(24);
  car.battery.cells[20].resistance_scale = 5.0;  // the sixth of six thermistors sits on cell 21
  Bench pack(car);
  pack.drive(5.0, 500.0);
  std::map<std::uint32_t, can::Temperatures> groups;
  for (std::uint32_t n = 0; n < 10; ++n) {
    for (const Frame& f : pack.tick(n)) {
      can::Temperatures m;
      if (can::decode(f, m)) groups[m.group] = m;
    }
  }
  LONGS_EQUAL(2, groups.size());
  DOUBLES_EQUAL(pack.car.pack().cell_temperature_c(20), groups[1].temperature_dc[2] * 0.1, 0.051);
  CHECK(groups[1].temperature_dc[2] > groups[0].temperature_dc[0]);
}

TEST(SensorFrames, AThermistorReadsTheSurfaceOfItsCell) {
  VehicleParameters car = vtm16e();
  car.battery.cells.resize(24);
  car.battery.cells[20].resistance_scale = 5.0;
  car.cell.surface_lag_s = 60.0;
  Bench pack(car);
  pack.drive(20.0, 500.0);
  double read_c = 0.0;
  for (std::uint32_t n = 0; n < 10; ++n) {
    for (const Frame& f : pack.tick(n)) {
      can::Temperatures m;
      if (can::decode(f, m) && m.group == 1) read_c = m.temperature_dc[2] * 0.1;
    }
  }
  CHECK(pack.car.pack().surface_temperature_c(20) < pack.car.pack().cell_temperature_c(20) - 0.2);
  DOUBLES_EQUAL(pack.car.pack().surface_temperature_c(20), read_c, 0.051);
}
