// SPDX-License-Identifier: Apache-2.0
#include "bms/plausibility.hpp"

#include "bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;

TEST_GROUP(Plausibility) {
  Config config = pack_config();
  Measured measured{};
  Pack pack{};
  const Instant start = Instant::from_ms(100);

  void setup() override {
    for (std::size_t i = 0; i < config.cells_in_series; ++i) cell(i, 39'000);
    for (std::size_t i = 0; i < config.temperature_sensors; ++i) {
      measured.temperature[i] = Sample<Temperature>{Temperature::from_raw(250), Instant::from_ms(1000), Quality::kGood};
    }
    measured.current.quality = measured.pack_voltage.quality = Quality::kGood;
  }
  void cell(std::size_t i, std::int32_t v) {
    measured.cell[i] = Sample<CellVoltage>{CellVoltage::from_raw(v), Instant::from_ms(1000), Quality::kGood};
  }
  void summary() { summarise(config, measured, start, pack); }
};

TEST(Plausibility, FindsExtremesSumAndWeakestCell) {
  cell(5, 38'000);
  cell(6, 40'000);
  measured.temperature[3].value = Temperature::from_raw(310);
  summary();
  LONGS_EQUAL(38'000, pack.cell_min.raw());
  LONGS_EQUAL(40'000, pack.cell_max.raw());
  LONGS_EQUAL(5, pack.weakest_cell);
  LONGS_EQUAL(24 * 39'000, pack.cell_sum.raw());
  LONGS_EQUAL(310, pack.temperature_max.raw());
  LONGS_EQUAL(250, pack.temperature_min.raw());
  CHECK(pack.complete_once);
}

TEST(Plausibility, OneCellThatIsNotGoodMakesTheSetIncomplete) {
  for (Quality quality : {Quality::kNone, Quality::kInvalid, Quality::kStale}) {
    measured.cell[23].quality = quality;
    pack = Pack{};
    summary();
    CHECK_FALSE(pack.cells_good);
    CHECK_FALSE(pack.complete_once);
  }
}

TEST(Plausibility, SampleThatNeverCameHasWaitedSinceTheStart) {
  measured.cell[2] = Sample<CellVoltage>{};
  measured.temperature[1] = Sample<Temperature>{};
  summary();
  LONGS_EQUAL(100, pack.oldest_cell.ms());
  LONGS_EQUAL(100, pack.oldest_temperature.ms());
}

// The clock stands at zero once in 49 days.
TEST(Plausibility, ASampleThatIsGoodAtTheClocksZeroHasCome) {
  const Instant before = Instant::from_ms(0xFFFF'FF00U);
  for (auto& sample : measured.cell) sample.time = Instant{};
  for (auto& sample : measured.temperature) sample.time = Instant{};
  summarise(config, measured, before, pack);
  LONGS_EQUAL(0, pack.oldest_cell.ms());
  LONGS_EQUAL(0, pack.oldest_temperature.ms());
}

TEST(Plausibility, NothingGoodLeavesNoWeakestCell) {
  measured = Measured{};
  summary();
  LONGS_EQUAL(kNoCell, pack.weakest_cell);
  LONGS_EQUAL(kNoCell, pack.hottest_sensor);
}

TEST(Plausibility, MismatchIsTriedAFewLsbOnBothSides) {
  pack.cell_sum = PackVoltage::from_raw(950'000);
  for (std::int32_t lsb : {-2, -1, 0, 1, 2}) {
    pack.sum_by_pack = PackVoltage::from_raw(1'000'000 + lsb);  // 5 % are 50'000
    CHECK_EQUAL(lsb > 0, voltages_disagree(config, pack));
  }
}

TEST(Plausibility, OfEqualCellsAndSensorsTheFirstIsNamed) {
  for (const std::size_t i : {3, 9, 17}) cell(i, 38'000);
  for (const std::size_t i : {2, 4}) measured.temperature[i].value = Temperature::from_raw(310);
  summary();
  LONGS_EQUAL(3, pack.weakest_cell);
  LONGS_EQUAL(2, pack.hottest_sensor);
}

TEST(Plausibility, TheHighestCellIsThatOfThisStep) {
  summary();
  for (std::size_t i = 0; i < config.cells_in_series; ++i) cell(i, 36'000);
  summary();
  LONGS_EQUAL(36'000, pack.cell_max.raw());
  LONGS_EQUAL(36'000, pack.cell_min.raw());
}

// BMS-022: of 24 readings, rounded down.
TEST(Plausibility, ThePacksChannelIsTheMeanOfItsReadingsInTheStepsOfTheCells) {
  for (std::size_t i = 0; i < 24; ++i) measured.cell_pack[i] = PackVoltage::from_raw(900'000);
  measured.cell_pack[5] = PackVoltage::from_raw(900'023);
  summary();
  LONGS_EQUAL(900'000, pack.sum_by_pack.raw());
  measured.cell_pack[5] = PackVoltage::from_raw(900'024);
  summary();
  LONGS_EQUAL(900'001, pack.sum_by_pack.raw());
}

TEST(Plausibility, OneCellAndOneSensorWaitForThemselvesAlone) {
  config.cells_in_series = config.temperature_sensors = 1;
  measured.cell[1] = Sample<CellVoltage>{};
  measured.temperature[1] = Sample<Temperature>{};
  summary();
  LONGS_EQUAL(1'000, pack.oldest_cell.ms());
  LONGS_EQUAL(1'000, pack.oldest_temperature.ms());
}
