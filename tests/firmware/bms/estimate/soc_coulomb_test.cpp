// SPDX-License-Identifier: Apache-2.0
#include "bms/estimate/soc_coulomb.hpp"

#include <cmath>

#include "bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;

TEST_GROUP(SocCoulomb) {
  Config config = pack_config();
  SocEstimate soc{};
  Sample<CellVoltage> cells[kMaxCells] = {};
  bool cells_good = true;

  void setup() override { all_cells(39'000); }
  void all_cells(std::int32_t v) {
    for (std::size_t i = 0; i < config.cells_in_series; ++i) {
      cells[i] = Sample<CellVoltage>{CellVoltage::from_raw(v), Instant{}, Quality::kGood};
    }
  }
  void at(std::uint32_t ms, Current i, Quality quality = Quality::kGood) {
    soc_coulomb(config, SocInput{cells, cells_good, Sample<Current>{i, Instant::from_ms(ms), quality}}, soc);
    now_ms = ms;
  }
  /// Steps that are no loss of the measurement.
  void until(std::uint32_t ms, Current i) {
    const auto step = static_cast<std::uint32_t>(config.measurement_lost_time.ms());
    while (now_ms < ms) at(ms - now_ms < step ? ms : now_ms + step, i);
  }
  std::uint32_t now_ms = 0;
};

TEST(SocCoulomb, StartsAtTheMeanOfTheCellsOpenCircuitVoltages) {
  cells[0].value = CellVoltage::from_raw(36'000);  // 50 %, the others 75 %
  at(0, Current{});
  CHECK(soc.valid);
  LONGS_EQUAL((23 * 750'000 + 500'000) / 24, soc.value.raw());
}

TEST(SocCoulomb, DoesNotStartUnderLoadOrWithACellMissing) {
  at(0, amps(1) + Current::from_raw(1));
  CHECK_FALSE(soc.valid);
  at(10, -amps(1) - Current::from_raw(1));
  CHECK_FALSE(soc.valid);
  cells_good = false;
  at(20, Current{});
  CHECK_FALSE(soc.valid);
  cells_good = true;
  at(30, Current{}, Quality::kStale);
  CHECK_FALSE(soc.valid);
  at(40, amps(1));
  CHECK(soc.valid);
}

TEST(SocCoulomb, OneHourAtOneTenthOfTheCapacityTakesTenPoints) {
  at(0, Current{});
  at(10, amps(1));
  for (std::uint32_t t = 20; t <= 3'600'010; t += 10) at(t, amps(1));
  LONGS_EQUAL(650'000, soc.value.raw());
}

TEST(SocCoulomb, ChargingRaisesItAndTheEndsAreHeld) {
  all_cells(41'990);
  at(0, Current{});
  at(10, amps(-400));
  until(10'000, amps(-400));
  LONGS_EQUAL(1'000'000, soc.value.raw());
  until(400'000, amps(400));
  LONGS_EQUAL(0, soc.value.raw());
}

// BMS-084
TEST(SocCoulomb, BeyondTheEndsItCountsFivePointsAndIsBackSoon) {
  all_cells(30'120);  // 1 %
  at(0, Current{});
  at(10, amps(100));
  until(600'000, amps(100));  // 167 points
  LONGS_EQUAL(0, soc.value.raw());
  until(625'000, amps(-100));  // 6.9 points back, and the ramp
  CHECK(soc.value.raw() > 15'000 && soc.value.raw() < 20'000);
}

// BMS-084
TEST(SocCoulomb, TheCountIsHeldFivePointsBeyondEitherEnd) {
  at(0, Current{});
  const std::int64_t full = std::int64_t{config.capacity_mah} * 7'200'000;
  until(1'000'000, amps(-400));
  CHECK(soc.charge == full + full / 20);
  until(2'000'000, amps(400));
  CHECK(soc.charge == -full / 20);
}

// BMS-083: what a record said stands where the cells cannot be asked.
TEST(SocCoulomb, StartsUnderLoadFromARecordAndAtRestFromTheCells) {
  soc.filter.restored = true;
  for (std::size_t i = 0; i < kMaxCells; ++i) soc.filter.cell[i].filter.s = i < 24 ? 1 << 27 : 1 << 28;
  soc.filter.cell[23].filter.s = (1 << 27) + 24 * (1 << 24);  // 0.0625 more of the mean
  const SocEstimate restored = soc;
  at(0, amps(100), Quality::kStale);
  CHECK_FALSE(soc.valid);
  at(10, amps(100));
  CHECK(soc.valid);
  DOUBLES_EQUAL(562'500, soc.value.raw(), 1);
  soc = restored;
  at(20, amps(1));
  LONGS_EQUAL(750'000, soc.value.raw());
}

TEST(SocCoulomb, CountsFromTheStartAloneWheneverThatIs) {
  at(1'000'000, Current{});
  const std::int64_t before = soc.charge;
  at(1'000'010, amps(100));
  CHECK(before - soc.charge == 1'000'000);
}

TEST(SocCoulomb, TheMeanOfTheCellsIsRoundedToTheNearest) {
  all_cells(36'000);
  cells[0].value = CellVoltage::from_raw(36'001);  // 83 ppm more: 3.46 in the mean
  at(0, Current{});
  LONGS_EQUAL(500'003, soc.value.raw());
}

// BMS-003
TEST(SocCoulomb, ACellAtRestIsOneOfAGoodCurrentWithinItsBoundEitherWay) {
  for (const std::int32_t ma : {-1'001, -1'000, 1'000, 1'001}) {
    CHECK_EQUAL(ma >= -1'000 && ma <= 1'000,
                at_rest(config, Sample<Current>{Current::from_raw(ma), Instant{}, Quality::kGood}));
  }
  CHECK_FALSE(at_rest(config, Sample<Current>{Current{}, Instant{}, Quality::kStale}));
}

// BMS-087
TEST(SocCoulomb, ANewGoodSampleCountsAndNoOtherDoes) {
  const auto count = [&](std::uint32_t ms, double amperes, Quality quality = Quality::kGood) {
    return count_charge(config, Sample<Current>{amps(amperes), Instant::from_ms(ms), quality}, soc);
  };
  soc.last_current = {amps(100), Instant::from_ms(1'000), Quality::kGood};
  soc.charge = 0;
  CHECK_FALSE(count(1'010, 100, Quality::kInvalid));
  CHECK_FALSE(count(1'000, 100));
  CHECK_FALSE(count(990, 100));
  CHECK(soc.charge == 0);
  CHECK(count(1'001, 100));
  CHECK(soc.charge == -200'000);
  soc.charge = 0;
  CHECK(count(1'501, 0));  // so long a loss is bridged
  CHECK(soc.charge == -500LL * 100'000);
}

TEST(SocCoulomb, LostCurrentIsBridgedByTheTrapezoid) {
  at(0, Current{});
  at(10, amps(100));
  SocEstimate without = soc;
  for (std::uint32_t t = 20; t < 410; t += 10) at(t, amps(100), Quality::kStale);
  at(410, amps(100));
  const SocEstimate bridged = soc;
  soc = without;
  for (std::uint32_t t = 20; t <= 410; t += 10) at(t, amps(100));
  CHECK(soc.charge == bridged.charge);
}

// BMS-087: the contactors have opened; what flowed before may have flowed until then.
TEST(SocCoulomb, AfterALongLossTheCurrentBeforeItCountsUntilTheContactorsOpened) {
  for (const std::uint32_t gap_ms : {510U, 10'000U, 3'600'000U}) {
    soc = SocEstimate{};
    at(0, Current{});
    at(10, amps(100));
    const std::int64_t before = soc.charge;
    at(10 + gap_ms, amps(100));
    CHECK(before - soc.charge == std::int64_t{2} * amps(100).raw() * config.measurement_lost_time.ms());
    const std::int64_t after = soc.charge;
    at(20 + gap_ms, amps(100));
    CHECK(after - soc.charge == std::int64_t{2} * amps(100).raw() * 10);
  }
}

TEST(SocCoulomb, RepeatedAndEarlierSamplesCountOnce) {
  at(0, Current{});
  at(10, amps(100));
  const std::int64_t charge = soc.charge;
  at(10, amps(100));
  at(5, amps(100));
  CHECK(soc.charge == charge);
}

// BMS-070
TEST(SocCoulomb, TwoThousandAmpereHoursAreCountedWithoutOverflow) {
  config.capacity_mah = 2'000'000;
  for (const std::int32_t percent : {1, 50, 99, 100}) {
    soc = SocEstimate{};
    all_cells(30'000 + 120 * percent);
    at(0, Current{});
    LONGS_EQUAL(10'000 * percent, soc.value.raw());
    at(10, amps(1000));
    DOUBLES_EQUAL(10'000.0 * percent, soc.value.raw(), 1.0);
    until(72'000'010, amps(percent == 1 ? 0 : 1000));  // 20 kAh
    if (percent != 1) LONGS_EQUAL(0, soc.value.raw());
  }
}

// BMS-003
TEST(SocCoulomb, StaysWithinHalfAPointOverAnEndurance) {
  all_cells(41'400);  // 95 %
  at(0, Current{});
  double true_mah = 9'500.0;
  double worst_points = 0;
  const auto current_a = [](double t_s) { return 14.0 + 60.0 * std::sin(0.9 * t_s) * std::sin(0.13 * t_s) + 0.0003; };
  for (std::uint32_t t = 10; t <= 2'100'000; t += 10) {
    for (int sub = 0; sub < 10; ++sub) true_mah -= current_a((t - 10 + sub + 0.5) / 1000.0) / 3600.0;
    at(t, amps(current_a(t / 1000.0)));
    worst_points = std::max(worst_points, std::fabs(soc.value.raw() / 1e4 - true_mah / 100.0));
  }
  std::printf("BMS-003: worst error %.4f points in 2100 s (bound 0.5)\n", worst_points);
  CHECK(worst_points < 0.5);
  CHECK_TEXT(worst_points < 0.01, "an integer sum has no reason to be off by more");
}

TEST_GROUP(RecountAtRest) {
  Config config = pack_config();
  SocEstimate soc{};
  CellVoltage cells[kMaxCells] = {};
  void setup() override {
    soc.valid = true;
    soc.value = Soc::from_raw(500'000);
    for (std::size_t i = 0; i < 24; ++i) cells[i] = CellVoltage::from_raw(i == 0 ? 36'000 : 39'000);
  }
  /// So many ppm a step of 0.1 mV, where the cells are.
  void flat(std::int32_t ppm_per_step) {
    config.ocv.count = 3;
    config.ocv.soc[0] = Soc::from_raw(0);
    config.ocv.voltage[0] = CellVoltage::from_raw(30'000);
    config.ocv.soc[1] = Soc::from_raw(100'000);
    config.ocv.voltage[1] = CellVoltage::from_raw(38'000);
    config.ocv.soc[2] = Soc::from_raw(100'000 + 2'000 * ppm_per_step);
    config.ocv.voltage[2] = CellVoltage::from_raw(40'000);
    for (auto& cell : cells) cell = CellVoltage::from_raw(39'000);
  }
};

// BMS-089
TEST(RecountAtRest, TheCountIsThatOfTheOpenCircuitVoltages) {
  recount_at_rest(config, cells, soc);
  LONGS_EQUAL((23 * 750'000 + 500'000) / 24, soc.value.raw());
  DOUBLES_EQUAL(1e-6 * soc.value.raw() * 10'000 * 7.2e6, static_cast<double>(soc.charge), 1e6);
}

// BMS-089
TEST(RecountAtRest, AFilterAndAnEstimateThatIsNoneAreLeftAlone) {
  for (const SocMethod method : {SocMethod::kNone, SocMethod::kEkf}) {
    config.soc_method = method;
    recount_at_rest(config, cells, soc);
    LONGS_EQUAL(500'000, soc.value.raw());
  }
  config.soc_method = SocMethod::kCoulomb;
  soc.valid = false;
  recount_at_rest(config, cells, soc);
  LONGS_EQUAL(500'000, soc.value.raw());
  CHECK(soc.charge == 0 && !soc.valid);
}

// BMS-089
TEST(RecountAtRest, WhereOneAndAHalfMillivoltsAreHalfAPointTheCountStands) {
  for (const std::int32_t ppm_per_step : {332, 335}) {  // times 15
    flat(ppm_per_step);
    soc.value = Soc::from_raw(500'000);
    recount_at_rest(config, cells, soc);
    LONGS_EQUAL(ppm_per_step < 334 ? 100'000 + 1'000 * ppm_per_step : 500'000, soc.value.raw());
  }
}

// BMS-089: 5000 ppm a cell in the mean, and no more.
TEST(RecountAtRest, TheDoubtOfAllCellsTogetherDecidesToTheMillionth) {
  for (const std::int32_t more : {0, 1}) {
    config.ocv.count = 3;
    config.ocv.voltage[1] = CellVoltage::from_raw(38'000);
    config.ocv.soc[1] = Soc::from_raw(100'000);
    config.ocv.voltage[2] = CellVoltage::from_raw(38'030);
    config.ocv.soc[2] = Soc::from_raw(110'000 + more);  // 5000 ppm in 15 steps, or one more in some of them
    for (auto& cell : cells) cell = CellVoltage::from_raw(38'020);
    cells[0] = CellVoltage::from_raw(38'016);
    soc.value = Soc::from_raw(500'000);
    recount_at_rest(config, cells, soc);
    CHECK_EQUAL(more == 1, soc.value.raw() == 500'000);
  }
}

// BMS-089
TEST(RecountAtRest, TheMeanIsRoundedToTheNearest) {
  for (auto& cell : cells) cell = CellVoltage::from_raw(36'000);
  cells[0] = CellVoltage::from_raw(36'001);  // 83 ppm more
  soc.value = Soc{};
  recount_at_rest(config, cells, soc);
  LONGS_EQUAL(500'003, soc.value.raw());
}
