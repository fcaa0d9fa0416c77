// SPDX-License-Identifier: Apache-2.0
#include "bms/bms_step.hpp"

#include "bench.hpp"
#include "driven_bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;

TEST_GROUP(BmsStep) {};

TEST(BmsStep, SilentBusLeavesEverythingOpenAndEveryLimitZero) {
  const Config config = pack_config();
  State state;
  for (std::uint32_t t = 0; t < 5000; t += 10) {
    const Output out = step(config, Input{Instant::from_ms(t), {}}, state);
    CHECK(all_open(out));
    LONGS_EQUAL(0, out.limits.discharge.value.raw());
    CHECK(out.state == can::BmsState::kInvalid);
    CHECK_FALSE(out.soc_valid);
  }
}

// BMS-002
TEST(BmsStep, InvalidConfigurationClosesNothingAndSaysSo) {
  Bench bench{Config{}};
  bench.request(false);
  bench.run(500);
  bench.request(true);
  bench.run(1000);
  CHECK(all_open(bench.out));
  CHECK(has(bench.out, can::BmsFault::kConfigInvalid));
  CHECK(bench.out.limits.discharge.reason == can::LimitReason::kFault);
}

TEST(BmsStep, IsReadySoonAfterTheFirstFrames) {
  Bench bench;
  const std::int32_t took = bench.until([](const Output& o) { return o.state == can::BmsState::kIdle; }, 3000);
  CHECK(took >= 0 && took <= 250);
}

TEST(BmsStep, SameFramesGiveTheSameDecisions) {
  Bench a, b;
  a.drive();
  b.drive();
  LONGS_EQUAL(a.out.limits.discharge.value.raw(), b.out.limits.discharge.value.raw());
  LONGS_EQUAL(a.state.steps, b.state.steps);
}

TEST(BmsStep, PackWithoutStateOfChargeMethodDrivesOnVoltageAlone) {
  Config config = pack_config();
  config.soc_method = SocMethod::kNone;
  Bench bench(config);
  bench.drive();
  CHECK(bench.out.state == can::BmsState::kTsActive);
  CHECK_FALSE(bench.out.soc_valid);
  CHECK(bench.out.limits.discharge.value > Current{});
}

// BMS-088
TEST(BmsStep, OpenVoltageOfTheReportedCellIsItsFiltersWhereThereIsOne) {
  Config config = pack_config();
  config.soc_method = SocMethod::kEkf;
  for (std::size_t i = 0; i < 2; ++i) {
    config.branches.series[i] = config.branches.branch1[i] = Resistance::from_raw(1'000);
    config.branches.time1[i] = config.branches.time2[i] = Duration::from_ms(10'000);
  }
  DrivenBench car(config, 0.9);
  car.cells[5].resistance = 1.5;
  car.drive();
  (void)car.lap_until([](const Output&) { return false; }, 120.0);
  car.run(0.3, 150.0);  // branches are still charged
  for (int tick = 0; tick < 24; ++tick) {
    const CellReport cell = car.tick(150.0).cell;
    DOUBLES_EQUAL(3.0 + 1.2 * car.cells[cell.cell].soc, 1e-4 * cell.open_voltage.raw(), 0.010);
    DOUBLES_EQUAL(cell.cell == 5 ? 3'000.0 : 2'000.0, cell.resistance.raw(), cell.cell == 5 ? 300.0 : 150.0);
  }
}

TEST(BmsStep, OpenVoltageOfTheReportedCellIsVoltagePlusDrop) {
  Bench bench;
  bench.drive();
  bench.current(amps(100));
  bench.run(200);
  LONGS_EQUAL(39'000 + 2'000, bench.out.cell.open_voltage.raw());  // 100 A * 2 mOhm = 0.2 V
}
