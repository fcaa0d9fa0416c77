// SPDX-License-Identifier: Apache-2.0
#include "race/intervention.hpp"

#include <algorithm>
#include <optional>

#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;
using namespace voltlap::plant::test;
using Kind = can::PlantFaultKind;

TEST_GROUP(Intervention) {
  Car car{vtm16e(), false, 0.001};
  SensorFrames frames{car.parameters(), 1};
  Switches held{.shutdown_closed = true};  ///< what the frames tell of

  /// Contactors follow their command, tables renew.
  void let_pass(double seconds) {
    for (int i = 0; i < seconds * 100.0; ++i) {
      for (int k = 0; k < 10; ++k) car.step(0.0);
      car.renew(0.01);
    }
  }
  void plant(Kind kind, std::uint8_t index = 0, std::int16_t value = 0) {
    CHECK(apply_plant_fault({0, kind, index, value}, car, frames.faults));
  }
  bool refuses(Kind kind, std::uint8_t index, std::int16_t value = 0) {
    return !apply_plant_fault({0, kind, index, value}, car, frames.faults);
  }
  /// The message as it is sent in the coming ten seconds.
  template <class Message>
  Message sent(std::optional<std::uint8_t> group = {}) {
    Message m;
    for (std::uint32_t ms = 0; ms < 10'000; ms += can::kTickMs) {
      TxQueue tx;
      frames.send(Instant::from_ms(ms), car, {}, held, tx);
      for (const Frame& f : tx) {
        if (!can::decode(f, m)) continue;
        if constexpr (requires { m.group; }) {
          if (group && m.group != *group) continue;
        }
        return m;
      }
    }
    FAIL("not sent");
    return m;
  }
};

TEST(Intervention, NothingIsOverriddenByDefault) {
  Pedals pedals{0.3, 0.4};
  Switches switches{.shutdown_closed = true, .ts_on = true};
  override_pedals({}, pedals);
  override_switches({}, switches);
  DOUBLES_EQUAL(0.3, pedals.accelerator, 0.0);
  DOUBLES_EQUAL(0.4, pedals.brake, 0.0);
  CHECK(switches.shutdown_closed && switches.ts_on && !switches.ready_to_drive && !switches.reset);
}

TEST(Intervention, EachPedalAndSwitchIsTakenOverByItself) {
  can::DriverOverride by;
  by.accelerator_ok = true;
  by.accelerator_ppm = 750'000;
  by.shutdown = can::SwitchOverride::kOff;
  by.reset = can::SwitchOverride::kOn;
  Pedals pedals{0.1, 0.2};
  Switches switches{.shutdown_closed = true, .ts_on = true};
  override_pedals(by, pedals);
  override_switches(by, switches);
  DOUBLES_EQUAL(0.75, pedals.accelerator, 1e-12);
  DOUBLES_EQUAL(0.2, pedals.brake, 0.0);
  CHECK(!switches.shutdown_closed && switches.ts_on && !switches.ready_to_drive && switches.reset);
  by = {};
  by.brake_ok = true;
  by.brake_ppm = 1'000'000;
  by.ts_on = can::SwitchOverride::kOff;
  by.ready_to_drive = can::SwitchOverride::kOn;
  override_pedals(by, pedals);
  override_switches(by, switches);
  DOUBLES_EQUAL(1.0, pedals.brake, 1e-12);
  CHECK(!switches.ts_on && switches.ready_to_drive);
}

TEST(Intervention, WeldedContactorStaysClosedAndAStuckOneOpen) {
  plant(Kind::kAirMinusWelded);
  plant(Kind::kPrechargeWelded);
  plant(Kind::kAirPlusStuckOpen);
  car.contactors.air_plus.command(true);
  let_pass(0.2);
  CHECK(car.contactors.air_minus.closed() && car.contactors.precharge.closed());
  CHECK_FALSE(car.contactors.air_plus.closed());
  plant(Kind::kAirPlusWelded);
  CHECK(car.contactors.air_plus.closed());
  plant(Kind::kAirMinusStuckOpen);
  plant(Kind::kPrechargeStuckOpen);
  CHECK(!car.contactors.air_minus.closed() && !car.contactors.precharge.closed());
}

TEST(Intervention, SlowContactorsTravelForSoMuchLongerBothWays) {
  plant(Kind::kAirPlusSlow, 0, 300);
  car.contactors.air_plus.command(true);
  car.contactors.air_minus.command(true);
  let_pass(0.2);
  CHECK(car.contactors.air_minus.closed() && !car.contactors.air_plus.closed());
  let_pass(0.2);
  CHECK(car.contactors.air_plus.closed());
  car.contactors.air_plus.command(false);
  let_pass(0.2);
  CHECK(car.contactors.air_plus.closed());
  let_pass(0.2);
  CHECK_FALSE(car.contactors.air_plus.closed());
}

TEST(Intervention, ChatteringContactorIsOpenHalfOfTheTimeAndOnlyWhileItIsCommanded) {
  car.contactors.air_minus.command(true);
  let_pass(0.2);
  plant(Kind::kAirMinusChatters, 0, 40);
  int closed = 0;
  for (int i = 0; i < 80; ++i) {
    let_pass(0.01);
    closed += car.contactors.air_minus.closed() ? 1 : 0;
  }
  CHECK(closed >= 38 && closed <= 42);  // of 80 steps; an edge may fall on either side of one
  car.contactors.air_minus.command(false);
  let_pass(0.2);
  for (int i = 0; i < 20; ++i) {
    let_pass(0.01);
    CHECK_FALSE(car.contactors.air_minus.closed());
  }
}

TEST(Intervention, StuckInverterGoesOnWithItsLastCommandAndAWeakOneGivesItsShare) {
  Inverter& inverter = car.inverter;
  inverter.command(200.0, true);
  plant(Kind::kInverterFollows, 0, 50);
  DOUBLES_EQUAL(100.0, inverter.current(90.0), 1e-12);
  plant(Kind::kClearAll);
  plant(Kind::kInverterStuck);
  inverter.command(0.0, false);
  inverter.advance(10.0);  // silence, too
  DOUBLES_EQUAL(200.0, inverter.current(90.0), 1e-12);
  DOUBLES_EQUAL(0.0, inverter.current(1.0), 0.0);  // without a DC link nothing flows
  plant(Kind::kClearAll);
  inverter.command(0.0, false);
  DOUBLES_EQUAL(0.0, inverter.current(90.0), 0.0);
}

TEST(Intervention, OpenPrechargeResistorKeepsTheDcLinkAtZero) {
  car.contactors.air_minus.command(true);
  car.contactors.precharge.command(true);
  plant(Kind::kPrechargeResistorOpen);
  let_pass(1.0);
  DOUBLES_EQUAL(0.0, car.dc_link_voltage(), 1e-9);
  plant(Kind::kClearAll);
  let_pass(1.0);
  CHECK(car.dc_link_voltage() > 0.9 * car.pack().voltage());
}

TEST(Intervention, LostCellReadingHasNoValueAndItsNeighboursHave) {
  plant(Kind::kCellLost, 4);
  const auto m = sent<can::CellVoltages>(1);
  CHECK(m.cell_ok[0] && !m.cell_ok[1] && m.cell_ok[2]);
}

TEST(Intervention, OffsetsMoveTheReadingAndNotTheTruth) {
  const auto cell = sent<can::CellVoltages>(0).cell_100uv[2];
  const auto thermistor = sent<can::Temperatures>(0).temperature_dc[1];
  const auto apps = sent<can::Pedals>();
  const double truth = car.pack().cell_voltage(2);
  plant(Kind::kCellOffset, 2, -250);
  plant(Kind::kThermistorOffset, 1, 305);
  plant(Kind::kApps1Offset, 0, 400);
  LONGS_EQUAL(cell - 2500, sent<can::CellVoltages>(0).cell_100uv[2]);
  LONGS_EQUAL(thermistor + 305, sent<can::Temperatures>(0).temperature_dc[1]);
  LONGS_EQUAL(apps.apps1_100uv + 4000, sent<can::Pedals>().apps1_100uv);
  LONGS_EQUAL(apps.apps2_100uv, sent<can::Pedals>().apps2_100uv);
  DOUBLES_EQUAL(truth, car.pack().cell_voltage(2), 0.0);
}

TEST(Intervention, InterlockAndIsolationMonitorSitInTheShutdownCircuit) {
  const auto told = [&] { return sent<can::VehicleIo>(); };
  CHECK(told().shutdown_closed && !told().interlock_open && !told().isolation_fault);
  plant(Kind::kInterlockOpen);
  CHECK(!told().shutdown_closed && told().interlock_open && !told().isolation_fault);
  plant(Kind::kClearAll);
  plant(Kind::kIsolationFault);
  CHECK(!told().shutdown_closed && !told().interlock_open && told().isolation_fault);
  plant(Kind::kClearAll);
  CHECK(told().shutdown_closed && !told().isolation_fault);
}

TEST(Intervention, FrozenReadingsStandWhileTheTruthGoesOn) {
  const auto cell = sent<can::CellVoltages>(0).cell_100uv[2];
  plant(Kind::kCellFrozen, 2);
  plant(Kind::kCurrentFrozen);
  car.renew(0.01);
  car.pack().advance(100.0);
  const auto m = sent<can::CellVoltages>(0);
  LONGS_EQUAL(cell, m.cell_100uv[2]);
  CHECK(m.cell_ok[2] && m.cell_100uv[1] < cell);
  LONGS_EQUAL(0, sent<can::PackSensor>().pack_current_ma);
}

TEST(Intervention, GainsOffsetsAndAStuckDcLinkChangeTheReading) {
  const auto cell = sent<can::CellVoltages>(0).cell_100uv[1];
  plant(Kind::kCellGain, 1, 1100);
  plant(Kind::kCurrentOffset, 0, -250);
  plant(Kind::kDcLinkStuck, 0, 960);
  DOUBLES_EQUAL(1.1 * cell, sent<can::CellVoltages>(0).cell_100uv[1], 1.0);
  LONGS_EQUAL(-2500, sent<can::PackSensor>().pack_current_ma);
  LONGS_EQUAL(960'000, sent<can::InverterStatus>().dc_link_voltage_100uv);
  plant(Kind::kCurrentReversed);
  plant(Kind::kClearAll);
  LONGS_EQUAL(cell, sent<can::CellVoltages>(0).cell_100uv[1]);
  LONGS_EQUAL(0, sent<can::PackSensor>().pack_current_ma);
  CHECK_FALSE(refuses(Kind::kCellGain, 0, 900));
  CHECK(refuses(Kind::kCellGain, 0, 0));
}

TEST(Intervention, LostThermistorCurrentAndBrakeSensorsSayNoValue) {
  plant(Kind::kThermistorLost, 0);
  plant(Kind::kCurrentLost);
  plant(Kind::kBrakeLost, 1);
  CHECK(!sent<can::Temperatures>(0).temperature_ok[0] && sent<can::Temperatures>(0).temperature_ok[1]);
  CHECK(!sent<can::PackSensor>().pack_current_ok && sent<can::PackSensor>().pack_voltage_ok);
  CHECK(sent<can::Pedals>().brake_front_ok && !sent<can::Pedals>().brake_rear_ok);
  plant(Kind::kBrakeLost, 0);
  CHECK_FALSE(sent<can::Pedals>().brake_front_ok);
}

TEST(Intervention, ResistanceOfOneCellIsScaledInTheTruth) {
  const auto sag = [&](std::size_t cell) {
    const double open = car.pack().cell_voltage(cell);
    car.pack().advance(100.0);
    const double drop = open - car.pack().cell_voltage(cell);
    car.pack().advance(-100.0);
    car.pack().advance(0.0);
    return drop;
  };
  car.renew(0.01);
  const double before = sag(3);
  plant(Kind::kCellResistanceScale, 3, 300);
  car.renew(0.01);
  DOUBLES_EQUAL(3.0, sag(3) / before, 0.1);  // the branches keep their time constants
  DOUBLES_EQUAL(1.0, sag(4) / before, 0.05);
}

TEST(Intervention, ClearingAllLeavesTheCarAsItWas) {
  const auto cell = sent<can::CellVoltages>(0).cell_100uv[0];
  for (const Kind kind :
       {Kind::kAirPlusWelded, Kind::kAirMinusWelded, Kind::kPrechargeWelded, Kind::kPrechargeResistorOpen,
        Kind::kCellLost, Kind::kThermistorLost, Kind::kCurrentLost, Kind::kBrakeLost}) {
    plant(kind);
  }
  plant(Kind::kApps1Offset, 0, 100);
  plant(Kind::kCellResistanceScale, 0, 1000);
  plant(Kind::kClearAll);
  CHECK(!car.contactors.air_plus.closed() && !car.contactors.air_minus.closed() && !car.contactors.precharge.closed());
  CHECK_FALSE(car.contactors.precharge_resistor_open);
  CHECK(sent<can::CellVoltages>(0).cell_ok[0]);
  LONGS_EQUAL(cell, sent<can::CellVoltages>(0).cell_100uv[0]);
  CHECK(sent<can::Temperatures>(0).temperature_ok[0] && sent<can::PackSensor>().pack_current_ok);
  CHECK(sent<can::Pedals>().brake_front_ok);
  LONGS_EQUAL(5'000, sent<can::Pedals>().apps1_100uv);
}

TEST(Intervention, PartThatTheCarDoesNotHaveIsRefused) {
  const auto cells = static_cast<std::uint8_t>(car.pack().cells());
  const auto thermistors = static_cast<std::uint8_t>(car.parameters().sensors.temperature_count);
  CHECK(refuses(Kind::kCellLost, cells));
  CHECK(refuses(Kind::kCellOffset, cells, 10));
  CHECK(refuses(Kind::kCellResistanceScale, cells, 200));
  CHECK(refuses(Kind::kCellResistanceScale, 0, 0));
  CHECK(refuses(Kind::kThermistorLost, thermistors));
  CHECK(refuses(Kind::kThermistorOffset, thermistors, 1));
  CHECK(refuses(Kind::kBrakeLost, 2));
  CHECK(frames.faults.cells.empty() && frames.faults.thermistors.empty());
  plant(Kind::kCellLost, static_cast<std::uint8_t>(cells - 1));
  plant(Kind::kThermistorLost, static_cast<std::uint8_t>(thermistors - 1));
  CHECK(refuses(Kind::kAirPlusSlow, 0, -1) && refuses(Kind::kAirPlusChatters, 0, 0) &&
        refuses(Kind::kInverterFollows, 0, -1));
}
