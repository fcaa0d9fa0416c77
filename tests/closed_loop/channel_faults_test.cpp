// SPDX-License-Identifier: Apache-2.0
// A channel lies while the car drives: how long until the contactors are open, and how far its cell has come by then.
#include <algorithm>
#include <string>

#include <fmt/format.h>

#include "bench.hpp"
#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

VehicleParameters noisy(double soc) {
  VehicleParameters car = vtm16e();
  car.sensors.noise = car.sensors.quantisation = true;
  car.battery.initial_soc = soc;
  return car;
}

bool told(const LoopBench& bench, can::BmsFault fault) {
  return (bench.commands.bms().faults >> static_cast<unsigned>(fault) & 1U) != 0;
}

/// Pedal on and off, as between corners.
void drive_on(LoopBench& bench, double seconds) {
  for (double t = 0.0; t < seconds; t += 0.01) {
    const bool straight = bench.now_ms() % 8000 < 6000;
    bench.pedals = straight ? Pedals{1.0, 0.0} : Pedals{0.0, 1.0};
    bench.tick();
  }
}

struct Reaction {
  double told_s = -1.0, open_s = -1.0;
  double least_cell_v = 10.0;  ///< of all cells, truly, until the contactors are open
};

/// From now on, until the contactors are open and the fault is told.
Reaction react(LoopBench& bench, can::BmsFault fault, double most_s) {
  Reaction out;
  for (double t = 0.0; t < most_s && out.open_s < 0.0; t += 0.01) {
    drive_on(bench, 0.01);
    if (out.told_s < 0.0 && told(bench, fault)) out.told_s = t;
    if (out.told_s >= 0.0 && !bench.any_air_closed()) out.open_s = t;
    out.least_cell_v = std::min(out.least_cell_v, bench.car.pack().cell_voltage_min());
  }
  return out;
}

void expect(const char* what, const Reaction& reaction, double within_s) {
  fmt::print("{}: told after {:.2f} s, open after {:.2f} s (bound {} s), lowest cell {:.3f} V\n", what, reaction.told_s,
             reaction.open_s, within_s, reaction.least_cell_v);
  CHECK_TEXT(reaction.told_s >= 0.0 && reaction.open_s >= 0.0 && reaction.open_s <= within_s, what);
  CHECK_TEXT(reaction.open_s - reaction.told_s < 0.15, what);
}

}  // namespace

TEST_GROUP(ChannelFaults){};

// BMS-060: today's car drove a cell to 1.82 V behind a frozen reading.
TEST(ChannelFaults, FrozenCellIsFoundBeforeItsTrueVoltageLeavesItsRange) {
  for (const double soc : {0.12, 0.5}) {
    LoopBench bench(noisy(soc), false);
    bench.drive_off(2.0);
    drive_on(bench, 10.0);
    SensorFaults::at(bench.faults().cells, 7).frozen = true;
    const Reaction reaction = react(bench, can::BmsFault::kCellImplausible, 60.0);
    expect(fmt::format("BMS-060 frozen at SOC {}", soc).c_str(), reaction, 15.0);
    CHECK(reaction.least_cell_v > 2.4);
  }
}

// BMS-061
TEST(ChannelFaults, CellThatReadsATenthTooMuchIsFound) {
  LoopBench bench(noisy(0.5), false);
  bench.drive_off(2.0);
  drive_on(bench, 10.0);
  SensorFaults::at(bench.faults().cells, 3).gain = 1.1;
  expect("BMS-061 gain 1.1", react(bench, can::BmsFault::kCellImplausible, 60.0), 15.0);
}

// BMS-066
TEST(ChannelFaults, ShuntTheWrongWayRoundIsFoundAtTheFirstPush) {
  LoopBench bench(noisy(0.8));
  bench.faults().current_gain = -1.0;
  bench.switches.shutdown_closed = true;
  bench.drive_off(0.0);
  expect("BMS-066 reversed", react(bench, can::BmsFault::kCurrentImplausible, 20.0), 3.0);
}

// BMS-066, BMS-067
TEST(ChannelFaults, FrozenCurrentIsFound) {
  LoopBench bench(noisy(0.8));
  bench.drive_off(2.0);
  drive_on(bench, 10.0);
  bench.faults().current_frozen = true;
  expect("BMS-066 frozen", react(bench, can::BmsFault::kCurrentImplausible, 60.0), 30.0);
}

// BMS-067
TEST(ChannelFaults, CurrentOfHalfTheTruthIsFoundByTheInvertersPower) {
  LoopBench bench(noisy(0.8));
  bench.drive_off(2.0);
  drive_on(bench, 10.0);
  bench.faults().current_gain = 0.45;
  expect("BMS-067", react(bench, can::BmsFault::kCurrentImplausible, 60.0), 20.0);
}

// BMS-068
TEST(ChannelFaults, OffsetOfTwoAmperesStartsAndDrives) {
  LoopBench bench(noisy(0.8));
  bench.faults().current_offset_a = 2.0;
  bench.drive_off(5.0);
  CHECK(bench.any_air_closed());
  LONGS_EQUAL(0, static_cast<long>(bench.commands.bms().faults));
  CHECK(bench.car.phase_current_a() > 0.0);
}

// BMS-032
TEST(ChannelFaults, DcLinkSensorStuckAtFullVoltageClosesNoContactorOntoAnEmptyLink) {
  LoopBench bench(noisy(0.8));
  bench.faults().dc_link_v = 96.0;
  bench.switches.shutdown_closed = true;
  bench.pedals = {0.0, 1.0};
  bench.run_for(0.5);
  bench.switches.ts_on = true;
  for (int i = 0; i < 1000; ++i) {
    bench.tick();
    CHECK_FALSE(bench.any_air_closed());
  }
  CHECK(told(bench, can::BmsFault::kContactorWelded));
}

// BMS-034
TEST(ChannelFaults, ContactorsOpenAfterTheTorqueHasGone) {
  LoopBench bench(noisy(0.8));
  bench.drive_off(0.2);
  for (int i = 0; i < 1500 && bench.car.pack_current_a() < 200.0; ++i) bench.tick();
  CHECK(bench.car.pack_current_a() >= 200.0);
  SensorFaults::at(bench.faults().cells, 3).lost = true;
  double opened_a = -1.0;
  int waited = 0;
  for (int i = 0; i < 200 && opened_a < 0.0; ++i) {
    const double before_a = bench.car.pack_current_a();
    bench.tick();
    if (told(bench, can::BmsFault::kCellMeasurementLost)) ++waited;
    if (!bench.any_air_closed()) opened_a = before_a;
  }
  fmt::print("BMS-034: contactors open {} ms after the fault is told, under {:.1f} A\n", 10 * waited, opened_a);
  CHECK(opened_a >= 0.0 && opened_a < 20.0);
  CHECK(waited <= 14);  // 100 ms, and 30 ms of commands and travel
}
