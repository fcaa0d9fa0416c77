// SPDX-License-Identifier: Apache-2.0
// The rule of BMS-061 in double precision beside the integers, over drawn levels, and what a level is made of.
#include <algorithm>
#include <cmath>
#include <random>

#include "bms/cell_check.hpp"
#include "bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;

namespace {

/// In volts and shares of the charge.
struct Level {
  double soc, start, own_start;    ///< of the neighbours now and at the first rest, of the cell then
  double apart, sag, rise;         ///< cell less neighbours; R |I| and what is charged on the whole
  double own_answer, all_answer;   ///< [mA 0.1 mV]
  int cells;
  bool explained;
};

double ocv_of(double soc) { return 3.0 + 1.2 * std::clamp(soc, 0.0, 1.0); }

/// How much more a cell answers than the mean of the others; 2 where nobody can say.
double more_of(const Level& x) {
  if (x.cells < 2 || !x.explained) return 2.0;
  const double others = (x.all_answer - x.own_answer) / (x.cells - 1);
  return others < 1.0 ? 2.0 : std::clamp(x.own_answer / others - 1.0, 0.0, 15.0);
}

/// Volts beyond what start, capacity and load explain; below zero: within.
double beyond(const Level& x) {
  const double margin = 0.03 + 0.5 * x.sag, spread = 0.03 + 0.25 * std::abs(x.soc - x.start);
  const double own = std::clamp(x.own_start - x.start, -0.1, 0.1), load = 1.5 * more_of(x) + 0.5;
  if (x.apart > 0.0) {
    return x.apart - (ocv_of(x.soc + std::max(own, 0.0) + spread) - ocv_of(x.soc) + margin + x.rise * load);
  }
  const double lowest = x.soc + std::min(own, 0.0) - spread;
  if (lowest < 0.0 || -x.apart < margin) return -1.0;  // below the end of the table anything is possible
  return ocv_of(lowest) - ocv_of(x.soc) - margin - x.sag * load - x.apart;
}

std::int32_t raw(double volts) { return static_cast<std::int32_t>(std::lround(1e4 * volts)); }
Soc soc_of(double soc) { return Soc::from_raw(static_cast<std::int32_t>(std::lround(1e6 * soc))); }

/// One reading of cell 0 at that level, in a step in which no time passes.
bool off_level(const Level& x) {
  Config config = pack_config();
  config.cells_in_series = static_cast<std::uint16_t>(x.cells);
  State s;
  s.cell_resistance = Resistance::from_raw(2'000);
  s.measured.arrived = 1;
  s.measured.current.quality = s.measured.pack_voltage.quality = s.measured.cell[0].quality = Quality::kGood;
  CellCheck& c = s.cell_check;
  c.based = c.wave.begun = c.cell[0].begun = true;
  c.soc = soc_of(x.soc);
  c.start = soc_of(x.start);
  c.sag = raw(x.sag);
  c.rise = raw(x.rise);
  c.level = 256 * raw(ocv_of(x.soc));
  CellTrack& t = c.cell[0];
  t.start = soc_of(x.own_start);
  t.level = c.level + 256 * raw(x.apart);
  t.xy = -static_cast<std::int64_t>(256.0 * x.own_answer);
  t.pack_answer.xz = -static_cast<std::int64_t>(x.all_answer);
  t.x_lagged = t.pack_answer.xz;
  t.pack_answer.xx = 1'000'000;
  t.pack_answer.zz = x.explained ? 0 : 1'000'000'000'000;
  check_cells(config, Instant{}, false, s);
  return t.off_level == 1;
}

}  // namespace

TEST_GROUP(CellLevel) {
  std::mt19937_64 random{9};
  double drawn(double low, double high) { return std::uniform_real_distribution(low, high)(random); }
  bool happens(double share) { return drawn(0.0, 1.0) < share; }
};

// BMS-061
TEST(CellLevel, IsOffWhereItsTwinInDoublePrecisionSaysSo) {
  int off = 0, within = 0;
  for (int draw = 0; draw < 200'000; ++draw) {
    Level x{};
    x.soc = drawn(0.0, 1.0);
    x.start = happens(0.5) ? x.soc + drawn(-0.02, 0.02) : drawn(0.0, 1.0);
    x.own_start = x.start + drawn(-0.2, 0.2);
    x.apart = drawn(-0.7, 0.7);
    x.sag = drawn(0.0, 0.05);
    x.rise = happens(0.5) ? drawn(0.0, 0.05) : 0.0;
    x.cells = happens(0.1) ? 1 : (happens(0.2) ? 2 : 24);
    x.explained = happens(0.7);
    x.all_answer = 1e9;
    x.own_answer = x.all_answer * (happens(0.3) ? drawn(0.3, 1.2) : drawn(-0.02, 0.2));
    const double over = beyond(x);
    if (std::abs(over) < 0.002) continue;  // steps of 0.1 mV and of a per cent decide
    CHECK_EQUAL(over > 0.0, off_level(x));
    ++(over > 0.0 ? off : within);
  }
  CHECK(off > 20'000 && within > 20'000);
}

namespace {

/// The least distance [0.1 mV] from its neighbours at which a cell is off its level; -1 within 5 V.
std::int32_t least_off(Level x, bool above) {
  std::int32_t within = 0, off = 50'000;
  const auto is_off = [&](std::int32_t apart) {
    x.apart = 1e-4 * (above ? apart : -apart);
    return off_level(x);
  };
  if (!is_off(off)) return -1;
  while (off - within > 1) {
    const std::int32_t middle = (within + off) / 2;
    (is_off(middle) ? off : within) = middle;
  }
  return off;
}

/// The same from beyond(), which is straight.
double twin_of_least_off(Level x, bool above) {
  x.apart = above ? 5.0 : -5.0;
  return beyond(x) < 0.0 ? -1.0 : 1e4 * (5.0 - beyond(x));
}

}  // namespace

// BMS-061
TEST(CellLevel, IsOffFromWhereItsTwinSaysSo) {
  for (int draw = 0; draw < 400; ++draw) {
    Level x{};
    x.soc = drawn(0.0, 1.0);
    x.start = happens(0.5) ? x.soc : drawn(0.0, 1.0);
    x.own_start = std::clamp(x.start + drawn(-0.2, 0.2), 0.0, 1.0);
    x.sag = 1e-4 * std::floor(drawn(0.0, 1'000.0));
    x.rise = happens(0.7) ? 1e-4 * std::floor(drawn(0.0, 1'000.0)) : 0.0;
    x.cells = happens(0.2) ? 2 : 24;
    x.explained = happens(0.8);
    // Even ones, for the rule has them in integers.
    const double percent = 2.0 * std::floor(happens(0.5) ? drawn(-20.0, 100.0) : drawn(0.0, 900.0));
    x.own_answer = 1e5 * (100.0 + percent);
    x.all_answer = x.own_answer + 1e7 * (x.cells - 1);
    for (const bool above : {false, true}) {
      const double twin = twin_of_least_off(x, above);
      const double low = x.soc + std::clamp(x.own_start - x.start, -0.1, 0.0) - 0.03 - 0.25 * std::abs(x.soc - x.start);
      if (!above && std::abs(low) < 1e-5) continue;  // the table's end to the millionth
      DOUBLES_EQUAL(twin, least_off(x, above), 3.0);
    }
  }
}

// BMS-061: 36 mV for what a start may be wrong, 30 mV for the channels; a millionth more of the charge is a step here.
TEST(CellLevel, IsOffFromTheStepBeyondItsBound) {
  Level x{};
  x.soc = x.start = 0.500041;
  x.cells = 24;
  for (const double own : {-1e-5, 0.0, 1e-5}) {
    x.own_start = x.start + own;
    if (own <= 0.0) LONGS_EQUAL(661, least_off(x, true));
    if (own >= 0.0) LONGS_EQUAL(661, least_off(x, false));
  }
  x.own_start = x.start;
  x.rise = 1e-4;  // 350 % of it while nobody knows how much more the cell sags
  LONGS_EQUAL(664, least_off(x, true));
}

// BMS-061: a cell that has all of the answer has no others to be held against; one step of theirs is enough.
TEST(CellLevel, WhereTheOthersAnswerNothingNobodyKnowsHowMuchMoreACellSags) {
  Level x{};
  x.soc = x.start = x.own_start = 0.500041;
  x.cells = 24;
  x.explained = true;
  x.sag = 0.01;
  for (const double others : {0.0, 1.0}) {
    x.own_answer = 1e9;
    x.all_answer = 1e9 + 23.0 * others;
    LONGS_EQUAL(others < 1.0 ? 661 + 50 + 350 : 661 + 50 + 2'300, least_off(x, false));
  }
  x.cells = 1;
  LONGS_EQUAL(661 + 50 + 350, least_off(x, false));
}

// BMS-061: three hundredths above the end of the table anything below is possible.
TEST(CellLevel, BelowTheEndOfTheTableAnythingIsPossible) {
  for (const int ppm : {29'999, 30'000}) {
    Level x{};
    x.soc = x.start = x.own_start = 1e-6 * ppm;
    x.cells = 24;
    CHECK_EQUAL(ppm >= 30'000, least_off(x, false) > 0);
    CHECK(least_off(x, true) > 0);
  }
}

// BMS-061: V + I R in steps of 0.1 mV / 256, held within 390 V, whatever a table says.
TEST(CellLevel, IsTheVoltageAndWhatItsResistanceTakesAndNeverWraps) {
  int held = 0;
  for (int draw = 0; draw < 20'000; ++draw) {
    Config config = pack_config();
    State s;
    const double uohm = std::exp(drawn(0.0, std::log(2.147e9))), ma = drawn(-1e6, 1e6);
    s.cell_resistance = Resistance::from_raw(static_cast<std::int32_t>(uohm));
    s.measured.arrived = 1;
    s.measured.current.quality = s.measured.pack_voltage.quality = s.measured.cell[0].quality = Quality::kGood;
    s.measured.cell[0].value = CellVoltage::from_raw(37'000);
    s.measured.cell_current[0] = Current::from_raw(static_cast<std::int32_t>(ma));
    check_cells(config, Instant{}, false, s);
    const double drop = 2.56e-3 * s.cell_resistance.raw() * s.measured.cell_current[0].raw();
    held += std::abs(drop) > 1e9 ? 1 : 0;
    DOUBLES_EQUAL(256.0 * 37'000 + std::clamp(drop, -1e9, 1e9), s.cell_check.cell[0].level, 257.0);
  }
  CHECK(held > 5'000);
}

// BMS-061
TEST(CellLevel, TheFirstRestIsOneInWhichEveryCellIsKnown) {
  const Config config = pack_config();
  State s;
  s.cell_resistance = Resistance::from_raw(2'000);
  s.pack.complete_once = true;
  for (std::size_t i = 0; i < 24; ++i) s.measured.cell[i].value = CellVoltage::from_raw(30'000);
  check_cells(config, Instant{}, true, s);
  CHECK_FALSE(s.cell_check.based);
  for (std::size_t i = 0; i < 24; ++i) s.measured.cell[i].value = CellVoltage::from_raw(36'000);
  s.pack.cells_good = true;
  check_cells(config, Instant::from_ms(100), true, s);
  CHECK(s.cell_check.based);
  LONGS_EQUAL(500'000, s.cell_check.start.raw());
}

// BMS-061: 10 mV at 2 mOhm are 5 A.
TEST(CellLevel, ACurrentIsChoppedWhereAKnownResistanceMakesTenMillivoltsOfIt) {
  for (const std::int32_t uohm : {-5, 0, 2'000}) {
    for (const std::int64_t ma : {4'999, 5'000}) {
      State s;
      s.cell_resistance = Resistance::from_raw(uohm);
      s.cell_check.wave.all = ma * ma;
      check_cells(pack_config(), Instant{}, true, s);
      CHECK_EQUAL(uohm > 0 && ma == 5'000, s.cell_check.chopped);
    }
  }
}

// BMS-061
TEST(CellLevel, AnAnswerToHardlyAnyCurrentIsNoResistance) {
  for (const std::int64_t xx : {0, 900, 249'999, 250'000}) {
    State s;
    s.cell_resistance = Resistance::from_raw(2'000);
    s.current_check.answer.xx = xx;
    s.current_check.answer.xz = -12'000'000;  // 0.2 ohm a cell: three times the table's at most
    check_cells(pack_config(), Instant{}, true, s);
    LONGS_EQUAL(xx == 250'000 ? 6'000 : 0, s.cell_check.resistance.raw());
  }
}
