// SPDX-License-Identifier: Apache-2.0
// How the filters start, from the voltages of cells at rest or from a record, and what each turn is told.
#include "bms/estimate/soc_ekf.hpp"
#include "bms/estimate/soc_record.hpp"
#include "estimate/filter_bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;

namespace {

double unit(std::int32_t raw) { return std::ldexp(raw, -kUnitBits); }
double variance(std::int32_t raw) { return std::ldexp(raw, -kVarianceBits); }

}  // namespace

TEST_GROUP(SocStart) {
  Config config = filtered_config();
  SocEstimate soc{};
  Sample<CellVoltage> samples[kMaxCells] = {};
  Current at_sample[kMaxCells] = {};
  bool bled[kMaxCells] = {};
  std::uint32_t ms = 500;
  Temperature temperature = Temperature::from_raw(250);
  bool temperature_known = true;
  double amperes = 0.0;

  void setup() override {
    make_model(config, soc.filter.model);
    read(37'000);
  }
  void read(std::int32_t raw) {
    for (auto& sample : samples) sample = {CellVoltage::from_raw(raw), now(), Quality::kGood};
  }
  [[nodiscard]] Instant now() const { return Instant::from_ms(ms); }
  void step() {
    const Sample<Current> current{amps(amperes), now(), Quality::kGood};
    for (Current& each : at_sample) each = current.value;
    soc_ekf(config, {samples, true, current, at_sample, now(), temperature, temperature_known, bled}, soc);
    ms += 10;
  }
  [[nodiscard]] const CellFilter& cell(std::size_t i) const { return soc.filter.cell[i].filter; }
  /// Quarter volts.
  [[nodiscard]] double ocv(double s) const {
    std::uint8_t interval = 0;
    const auto raw = static_cast<std::int32_t>(std::lround(std::ldexp(s, kUnitBits)));
    return std::ldexp(ocv_at(soc.filter.model, raw, interval).voltage, -kVoltageBits);
  }
  /// A record of all cells; branches in quarter volts.
  void remember(double s, double v1 = 0.0, double v2 = 0.0) {
    SocRecord record;
    record.cells = config.cells_in_series;
    for (CellRecord& each : record.cell) {
      each.soc = static_cast<std::int16_t>(std::lround(std::ldexp(s, 14)));
      each.v1 = static_cast<std::int16_t>(std::lround(std::ldexp(v1, 12)));
      each.v2 = static_cast<std::int16_t>(std::lround(std::ldexp(v2, 12)));
      each.scale = 3U << 12;  // 1.5
    }
    soc = SocEstimate{};
    make_model(config, soc.filter.model);
    restore(config, record, soc);
  }
  /// Whether a record is believed by cells at rest that read so much.
  bool believed(double s, double v1, double v2, double quarter_volts) {
    remember(s, v1, v2);
    read(static_cast<std::int32_t>(std::lround(2'500.0 * quarter_volts)));
    step();
    CHECK(soc.valid);
    return std::abs(unit(cell(0).s) - s) < 1e-3;
  }
};

// BMS-080
TEST(SocStart, FromTheVoltageItDoubtsHalfAPointAndWhatFiveMillivoltsAreWorth) {
  for (const std::int32_t raw : {32'000, 36'000, 37'000, 40'000}) {
    soc = SocEstimate{};
    make_model(config, soc.filter.model);
    read(raw);
    step();
    const CellCovariance& p = cell(5).p;
    std::uint8_t interval = 0;
    const double slope = std::ldexp(ocv_at(soc.filter.model, cell(5).s, interval).slope, -kSlopeBits);
    DOUBLES_EQUAL(std::pow(0.02 / slope, 2) + 0.005 * 0.005, variance(p.ss), 2e-7);
    DOUBLES_EQUAL(0.02 * 0.02, variance(p.v11), 1e-9);
    DOUBLES_EQUAL(0.02 * 0.02, variance(p.v22), 1e-9);
    DOUBLES_EQUAL(0.3 * 0.3, variance(p.rr), 1e-9);
    DOUBLES_EQUAL(0.15 * 0.15, variance(p.ff), 1e-9);
  }
}

// BMS-080
TEST(SocStart, OnAFlatPartItDoubtsAsMuchAsItCanWhateverTheSlope) {
  for (int rise = 1; rise <= 40; ++rise) {  // 0.1 mV over three tenths of the charge
    config.ocv.voltage[2] = config.ocv.voltage[1] + CellVoltage::from_raw(rise);
    soc = SocEstimate{};
    make_model(config, soc.filter.model);
    read(config.ocv.voltage[1].raw());
    step();
    DOUBLES_EQUAL(0.1, variance(cell(5).p.ss), 1e-9);
  }
}

// BMS-082
TEST(SocStart, FromARecordItDoubtsThreePointsAndAllThatTheBranchesHeld) {
  amperes = 50.0;  // under load nothing contradicts it
  remember(0.6, 0.2, -0.1);
  step();
  CHECK(soc.valid);
  DOUBLES_EQUAL(0.6, unit(cell(7).s), 1e-4);
  DOUBLES_EQUAL(1.5, unit(cell(7).rho), 1e-6);
  const CellCovariance& p = cell(7).p;
  DOUBLES_EQUAL(0.03 * 0.03, variance(p.ss), 1e-9);
  DOUBLES_EQUAL(0.2 * 0.2 + 0.02 * 0.02, variance(p.v11), 2e-5);
  DOUBLES_EQUAL(0.1 * 0.1 + 0.02 * 0.02, variance(p.v22), 2e-5);
  DOUBLES_EQUAL(0.1 * 0.1, variance(p.rr), 1e-9);
  DOUBLES_EQUAL(0.125 * 0.125, variance(p.ff), 1e-9);
  for (std::size_t i = 0; i < config.cells_in_series; ++i) CHECK(cell(i).from_record);
}

// BMS-082: ten points, 5 mV and what the branches may still hold, on either side.
TEST(SocStart, ARecordIsBelievedAsFarAsTheCellsAtRestAllowIt) {
  constexpr double kMargin = 0.02, kBeside = 0.0008;  // quarter volts: 5 mV, and 0.2 mV to be on either side
  for (const auto& [v1, v2] : {std::pair{0.0, 0.0}, {0.08, 0.02}, {-0.08, -0.02}, {0.08, -0.1}, {-0.02, 0.06}}) {
    const double held = v1 + v2, s = 0.55;
    const double low = ocv(s - 0.1) - std::max(held, 0.0) - kMargin;
    const double high = ocv(s + 0.1) - std::min(held, 0.0) + kMargin;
    CHECK(believed(s, v1, v2, low + kBeside));
    CHECK_FALSE(believed(s, v1, v2, low - kBeside));
    CHECK(believed(s, v1, v2, high - kBeside));
    CHECK_FALSE(believed(s, v1, v2, high + kBeside));
  }
}

// BMS-082
TEST(SocStart, OneCellThatContradictsItLeavesTheWholeRecord) {
  for (const std::size_t off : {std::size_t{0}, std::size_t{11}, std::size_t{23}}) {
    remember(0.55);
    read(36'950);
    samples[off].value = CellVoltage::from_raw(41'000);
    step();
    for (std::size_t i = 0; i < config.cells_in_series; ++i) CHECK_EQUAL(i == off, unit(cell(i).s) > 0.9);
    CHECK(std::abs(unit(cell(5).s) - 0.55) < 0.01);
    DOUBLES_EQUAL(0.3 * 0.3, variance(cell(5).p.rr), 1e-9);  // as from a voltage
  }
}

// BMS-080, BMS-082: what a contradicted record knew of the resistance stays, what it knew of the branches does not.
TEST(SocStart, FromTheVoltageBranchesAreEmptyAndAResistanceThatWasLearnedStays) {
  remember(0.2, 0.3, 0.1);
  read(40'000);
  step();
  LONGS_EQUAL(0, cell(3).v1);
  LONGS_EQUAL(0, cell(3).v2);
  DOUBLES_EQUAL(1.5, unit(cell(3).rho), 1e-6);
  soc = SocEstimate{};
  make_model(config, soc.filter.model);
  soc.filter.cell[3].filter.rho = 2 * kUnit;  // nobody's
  soc.filter.cell[3].filter.v1 = soc.filter.cell[3].filter.v2 = kUnit;
  step();
  LONGS_EQUAL(kUnit, cell(3).rho);
  LONGS_EQUAL(0, cell(3).v1);
  LONGS_EQUAL(0, cell(3).v2);
}

// BMS-080
TEST(SocStart, NothingOfAnEarlierCountIsLeft) {
  soc.charge = 987'654'321;
  soc.value = Soc::from_raw(123);
  soc.filter.sum = std::int64_t{1} << 40;
  soc.filter.charge_bits = 9;
  for (FilteredCell& each : soc.filter.cell) each.charge = 1'000'000'000;
  step();
  LONGS_EQUAL(0, soc.charge);
  LONGS_EQUAL(500, (soc.last_current.time - Instant{}).ms());
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < config.cells_in_series; ++i) {
    LONGS_EQUAL(0, soc.filter.cell[i].charge);
    LONGS_EQUAL(0, (soc.filter.cell[i].stepped - Instant::from_ms(500)).ms());
    sum += cell(i).s;
  }
  CHECK_EQUAL(sum, soc.filter.sum);
  CHECK(soc.filter.per_charge >= 1 << 27 && soc.filter.per_charge <= 1 << 28);
  LONGS_EQUAL(0, cell(config.cells_in_series).p.ss);  // no cell more than there are
  LONGS_EQUAL(1'000'000'000, soc.filter.cell[config.cells_in_series].charge);
}

TEST(SocStart, WithoutAStartTheLastValueStands) {
  soc.value = Soc::from_raw(123);
  amperes = 20.0;
  step();
  CHECK_FALSE(soc.valid);
  LONGS_EQUAL(123, soc.value.raw());
}

// BMS-080
TEST(SocStart, PartsFollowTheTemperatureAndTheFirstIsRemembered) {
  const auto check_warm = [this](std::int32_t raw) {
    const PartFactors expected = factors_of(soc.filter.model.by_temperature, raw);
    LONGS_EQUAL(expected.r0, soc.filter.warm.r0);
    LONGS_EQUAL(expected.r2, soc.filter.warm.r2);
    LONGS_EQUAL(raw, soc.filter.heat_of.raw());
  };
  temperature_known = false;
  step();
  step();
  CHECK_FALSE(soc.filter.heat_known);
  temperature_known = true;
  temperature = Temperature::from_raw(0);  // as a state that was never told says, too
  step();
  CHECK(soc.filter.heat_known);
  check_warm(0);
  temperature = Temperature::from_raw(310);
  step();
  check_warm(310);
  LONGS_EQUAL(0, soc.filter.heat_began.raw());
  temperature_known = false;
  temperature = Temperature::from_raw(400);
  step();
  check_warm(310);
}

TEST(SocStart, TheFirstTemperatureIsTheOneAtWhichTheHeatBegan) {
  step();
  step();
  LONGS_EQUAL(250, soc.filter.heat_began.raw());
  temperature = Temperature::from_raw(270);
  step();
  LONGS_EQUAL(250, soc.filter.heat_began.raw());
}

// BMS-055
TEST(SocStart, ACellThatIsBledIsNotReadAndTheOthersAre) {
  step();
  const std::int32_t before = cell(0).s;
  bled[4] = true;
  for (int k = 0; k < 100; ++k) {
    read(39'000);
    step();
  }
  for (std::size_t i = 0; i < config.cells_in_series; ++i) CHECK_EQUAL(i != 4, cell(i).s != before);
}

// A reading is one, however often its cell has its turn.
TEST(SocStart, AReadingIsTakenOnce) {
  step();
  const auto round = [this] {
    for (int k = 0; k < 8; ++k) step();
  };
  round();
  std::int32_t before[24];
  const auto note = [&] {
    for (std::size_t i = 0; i < 24; ++i) before[i] = cell(i).s;
  };
  note();
  read(38'000);
  round();
  for (std::size_t i = 0; i < 24; ++i) CHECK(cell(i).s != before[i]);
  note();
  round();
  round();
  for (std::size_t i = 0; i < 24; ++i) LONGS_EQUAL(before[i], cell(i).s);
  for (std::size_t i = 0; i < 24; ++i) {  // a millisecond newer than the cell's last turn
    samples[i].time = soc.filter.cell[i].stepped + Duration::from_ms(1);
  }
  round();
  for (std::size_t i = 0; i < 24; ++i) CHECK(cell(i).s != before[i]);
}
