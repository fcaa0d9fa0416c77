// SPDX-License-Identifier: Apache-2.0
#include "bms/estimate/soc_ekf.hpp"

#include "bms/estimate/soc_record.hpp"
#include "estimate/filter_bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;

TEST_GROUP(SocEkf) {
  Config config = filtered_config();
  SocEstimate soc{};
  std::vector<TrueCell> cells = std::vector<TrueCell>(24);
  Sample<CellVoltage> samples[kMaxCells] = {};
  Current at_sample[kMaxCells] = {};
  std::uint32_t ms = 0;
  bool lost = false;
  bool model_is_whole = true;  ///< from the first step on, as it is on a car before its first frames

  void step(double amperes) {
    if (model_is_whole && soc.filter.model.points == 0) make_model(config, soc.filter.model);
    ms += 10;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      cells[i].advance(amperes, 0.01);
      const auto raw = static_cast<std::int32_t>(std::lround(1e4 * cells[i].voltage(config)));
      samples[i] = {CellVoltage::from_raw(raw), Instant::from_ms(ms), lost ? Quality::kStale : Quality::kGood};
      at_sample[i] = amps(amperes);
    }
    const Sample<Current> current{amps(amperes), Instant::from_ms(ms), Quality::kGood};
    soc_ekf(config, {samples, !lost, current, at_sample, Instant::from_ms(ms), Temperature::from_raw(250), true}, soc);
  }
  void drive(double seconds) {
    for (double t = 0.0; t < seconds; t += 0.01) step(std::fmod(t, 4.0) < 2.0 ? 60.0 : 5.0);
  }
  void rest(double seconds) {
    for (double t = 0.0; t < seconds; t += 0.01) step(0.0);
  }
  double mean() const {
    double sum = 0.0;
    for (const TrueCell& cell : cells) sum += cell.soc;
    return sum / static_cast<double>(cells.size());
  }
  double error(std::size_t i) const { return 1e-6 * cell_soc(soc, i).raw() - cells[i].soc; }
  /// Power lost, and the supply back with what was kept.
  void restart(bool with_record = true) {
    SocRecord record;
    keep(config, soc, record);
    soc = SocEstimate{};
    if (with_record) restore(config, record, soc);
  }
};

// BMS-080
TEST(SocEkf, NothingStartsBeforeTheModelIsWhole) {
  model_is_whole = false;
  int steps = 0;
  for (; !soc.valid && steps < 100; ++steps) step(0.0);
  LONGS_EQUAL(3, steps);
  DOUBLES_EQUAL(0.9, 1e-6 * cell_soc(soc, 4).raw(), 1e-3);
}

// BMS-080
TEST(SocEkf, StartsAtEveryCellsOwnOpenCircuitVoltage) {
  cells[3].soc = 0.55;
  step(0.0);
  CHECK(soc.valid);
  DOUBLES_EQUAL(0.55, 1e-6 * cell_soc(soc, 3).raw(), 1e-3);
  DOUBLES_EQUAL(0.9, 1e-6 * cell_soc(soc, 4).raw(), 1e-3);
  DOUBLES_EQUAL(mean(), 1e-6 * soc.value.raw(), 1e-3);
}

TEST(SocEkf, DoesNotStartUnderLoadOrWithACellMissing) {
  step(20.0);
  CHECK_FALSE(soc.valid);
  lost = true;
  step(0.0);
  CHECK_FALSE(soc.valid);
}

// BMS-080
TEST(SocEkf, FollowsThePackAndAWeakCellOverADischarge) {
  cells[7].capacity_ah = 8.5;
  cells[7].resistance = 1.4;
  step(0.0);
  double worst = 0.0, worst_weak = 0.0;
  for (int k = 0; k < 60; ++k) {
    drive(12.0);
    worst = std::max(worst, std::abs(1e-6 * soc.value.raw() - mean()));
    worst_weak = std::max(worst_weak, std::abs(error(7)));
  }
  std::printf("BMS-080: pack within %.2f points, weak cell (15 %% less, 40 %% more resistance) within %.2f\n",
              100.0 * worst, 100.0 * worst_weak);
  CHECK(worst < 0.005);
  CHECK(worst_weak < 0.03);
}

// BMS-085
TEST(SocEkf, NoStepCarriesMoreThanATenthOfTheCellsAndEachHasItsTurnTenTimesASecond) {
  step(0.0);
  for (int k = 0; k < 50; ++k) {
    Instant before[kMaxCells];
    for (std::size_t i = 0; i < cells.size(); ++i) before[i] = soc.filter.cell[i].stepped;
    step(30.0);
    int stepped = 0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      stepped += (soc.filter.cell[i].stepped - before[i]).ms() != 0 ? 1 : 0;
      CHECK((Instant::from_ms(ms) - soc.filter.cell[i].stepped).ms() <= 100);
    }
    LONGS_EQUAL(cells_in_turn(24), stepped);
  }
  LONGS_EQUAL(3, cells_in_turn(24));
  LONGS_EQUAL(15, cells_in_turn(144));
  LONGS_EQUAL(1, cells_in_turn(1));
}

TEST(SocEkf, EveryAmpereSecondIsCountedWhateverTheTurns) {
  step(0.0);
  for (int k = 0; k < 1'000; ++k) {
    lost = k > 5;  // nothing but the count
    step(k % 7 == 0 ? 290.0 : 3.0);
  }
  for (int k = 0; k < 20; ++k) step(0.0);
  DOUBLES_EQUAL(mean(), 1e-6 * soc.value.raw(), 2e-4);
}

// BMS-082
TEST(SocEkf, ARestartInMidLapMovesTheChargeByLessThanTwoPoints) {
  rest(0.1);
  drive(300.0);
  for (const double gone_s : {0.1, 30.0, 600.0}) {
    const double before = 1e-6 * soc.value.raw();
    const double true_before = mean();
    restart();
    for (TrueCell& cell : cells) cell.advance(0.0, gone_s);
    double moved = 0.0;
    for (int k = 0; k < 50; ++k) {
      drive(0.5);
      moved = std::max(moved, std::abs(1e-6 * soc.value.raw() - before + true_before - mean()));
    }
    CHECK(soc.valid);
    CHECK(moved < 0.02);
    std::printf("BMS-082: off for %.1f s, the charge moves by %.2f points\n", gone_s, 100.0 * moved);
  }
}

// BMS-082
TEST(SocEkf, WithoutARecordTheSameRestartReadsTheSagAsCharge) {
  rest(0.1);
  drive(300.0);
  const double before = 1e-6 * soc.value.raw();
  restart(false);
  rest(0.1);
  CHECK(before - 1e-6 * soc.value.raw() > 0.02);
}

// BMS-082
TEST(SocEkf, ARecordOfAnotherTimeIsLeftForTheOpenCircuitVoltage) {
  rest(0.1);
  drive(300.0);
  restart();
  for (TrueCell& cell : cells) cell = TrueCell{};
  for (TrueCell& cell : cells) cell.soc = 1.0;  // charged meanwhile
  rest(0.1);
  DOUBLES_EQUAL(1.0, 1e-6 * soc.value.raw(), 0.005);
}

// BMS-086
TEST(SocEkf, CapacityAndResistanceAreLearnedSlowlyAndKept) {
  for (TrueCell& cell : cells) cell.capacity_ah = 9.0;
  step(0.0);
  drive(600.0);  // 54 points
  rest(1'800.0);
  const double fade = std::ldexp(soc.filter.cell[5].filter.fade, -kUnitBits);
  std::printf("BMS-086: capacity %.2f Ah of 9.00 after a swing of %.0f points\n", 10.0 / (1.0 + fade),
              100.0 * (0.9 - mean()));
  DOUBLES_EQUAL(9.0, 10.0 / (1.0 + fade), 0.03 * 9.0);
  restart();
  rest(0.2);
  DOUBLES_EQUAL(fade, std::ldexp(soc.filter.cell[5].filter.fade, -kUnitBits), 1e-3);
}
