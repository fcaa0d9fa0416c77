// SPDX-License-Identifier: Apache-2.0
// What is said of a cell by what is remembered of it: one reading in a step in which no time passes, so that it stays.
#include <algorithm>
#include <cmath>
#include <random>

#include "bms/cell_check.hpp"
#include "bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;

namespace {

constexpr std::int64_t kLargest = 1'000'000'000;  // [mA 0.1 mV] an answer that is explained by xx below

/// The pack answers with `all`, the first cell with `own`.
State answering(std::int64_t own, std::int64_t all) {
  State s;
  s.cell_resistance = Resistance::from_raw(2'000);
  s.measured.arrived = 1;
  s.measured.current.quality = s.measured.pack_voltage.quality = s.measured.cell[0].quality = Quality::kGood;
  s.cell_check.wave.begun = s.cell_check.cell[0].begun = true;
  s.cell_check.wave.all = s.cell_check.wave.slow = 1;
  CellTrack& t = s.cell_check.cell[0];
  t.xy = -256 * own;
  t.pack_answer.xz = t.x_lagged = -all;
  t.pack_answer.xx = 10'000'000;
  return s;
}

Config pack_of(std::uint16_t cells) {
  Config config = pack_config();
  config.cells_in_series = cells;
  return config;
}

bool frozen_in(State& s, std::uint16_t cells) {
  check_cells(pack_of(cells), Instant{}, false, s);
  return s.cell_check.cell[0].no_answer > 0;
}

}  // namespace

TEST_GROUP(CellJudge){};

// BMS-060: a third of its part of what the cell that sags most leaves; of one and of two all share.
TEST(CellJudge, AChannelIsFrozenBelowAThirdOfItsPartOfTheAnswer) {
  for (const std::uint16_t cells : {std::uint16_t{1}, std::uint16_t{2}, std::uint16_t{3}, std::uint16_t{24}}) {
    for (const std::int32_t rest : {1'000, 750}) {
      const std::int64_t others = cells > 2 ? cells - 1 : cells;
      const std::int64_t least = kLargest / 1'000 * rest / (3 * others);  // rounded down
      for (const std::int64_t off : {0, 1}) {
        State s = answering(least + off, kLargest);
        s.cell_check.rest = rest;
        CHECK_EQUAL(3'000 * others * (least + off) < kLargest * rest, frozen_in(s, cells));
      }
    }
  }
  State just = answering(kLargest / 69, kLargest / 69 * 69);
  CHECK_FALSE(frozen_in(just, 24));
}

// BMS-060: of the pack's answer in the same step and after the lag the smaller one.
TEST(CellJudge, TheSmallerAnswerOfThePackIsWhatACellMustHaveItsPartOf) {
  for (const bool sampled : {true, false}) {
    State s = answering(kLargest / 69 / 2 + 1, kLargest);
    CHECK(frozen_in(s, 24));
    s = answering(kLargest / 69 / 2 + 1, kLargest);
    CellTrack& t = s.cell_check.cell[0];
    (sampled ? t.pack_answer.xz : t.x_lagged) /= 2;
    CHECK_FALSE(frozen_in(s, 24));
  }
}

// BMS-060: 5 mV a cell, and a quarter of the current's changes after the lag.
TEST(CellJudge, OnlyACurrentThatMovesThePackSlowlyEnoughAccuses) {
  for (const std::uint16_t cells : {std::uint16_t{2}, std::uint16_t{24}}) {
    const std::int64_t least = 50 * cells;  // E = all^2 / xx
    for (const double share : {0.98, 1.02}) {
      State s = answering(0, static_cast<std::int64_t>(share * static_cast<double>(least) * 20'000.0));
      s.cell_check.cell[0].pack_answer.xx = 400'000'000;
      CHECK_EQUAL(share > 1.0, frozen_in(s, cells));
    }
  }
  for (const std::int64_t slow : {249, 250, 251}) {
    State s = answering(0, kLargest);
    s.cell_check.wave.all = 1'000;
    s.cell_check.wave.slow = slow;
    s.cell_check.cell[0].pack_answer.zz = 1'000'000;
    CHECK_EQUAL(slow >= 250, frozen_in(s, 24));
  }
}

// BMS-060: a third of a 24th of the pack's movement is 1'000'000 * 4096 / 72^2 in the units of a cell.
TEST(CellJudge, AChannelThatMovesIsNotFrozenWhileTheCurrentIsChoppedByAThirdOfItsSlowChanges) {
  constexpr std::int64_t kThird = 1'000'000LL * 4'096 / (72 * 72);
  for (const std::int64_t chopped : {999, 1'000, 1'001}) {
    for (const std::int64_t moved : {kThird - 1, kThird}) {
      State s = answering(0, kLargest);
      s.cell_check.wave.all = s.cell_check.wave.slow = 9'000;
      s.cell_check.wave.chopped = chopped;
      s.cell_check.cell[0].pack_answer.zz = 1'000'000;
      s.cell_check.cell[0].yy = moved;
      CHECK_EQUAL(chopped < 1'000 || moved < kThird, frozen_in(s, 24));
    }
  }
}

// BMS-060, BMS-061
TEST(CellJudge, FiveReadingsInARowAccuseAndOneThatIsSoundBeginsAnew) {
  for (const bool level : {false, true}) {
    const auto accused = [&](const State& s) { return level ? s.cell_check.off_level : s.cell_check.frozen; };
    State sound = answering(kLargest / 24, kLargest);
    sound.cell_check.based = true;
    sound.cell_check.soc = sound.cell_check.start = sound.cell_check.cell[0].start = Soc::from_raw(500'000);
    for (CellTrack& t : sound.cell_check.cell) t.level = 256 * 36'000;
    sound.cell_check.level = 256 * 36'000;
    State s = sound;
    const auto read = [&](bool wrong) {
      CellTrack& t = s.cell_check.cell[0];
      t.xy = wrong && !level ? 0 : sound.cell_check.cell[0].xy;
      t.level = 256 * (wrong && level ? 40'000 : 36'000);
      s.cell_check.level = 256 * 36'000;
      check_cells(pack_config(), Instant{}, false, s);
      s.measured.arrived = 0;
      s.measured.current.time = Instant::from_ms(1);  // no reading: what was said is told
      check_cells(pack_config(), Instant{}, true, s);
      s.measured.arrived = 1;
      s.measured.current.time = Instant{};
      s.cell_check.soc = s.cell_check.start;
      s.cell_check.rest = kAllAnswers;
    };
    for (int k = 0; k < 4; ++k) read(true);
    LONGS_EQUAL(kNoCell, accused(s));
    read(false);
    for (int k = 0; k < 4; ++k) read(true);
    LONGS_EQUAL(kNoCell, accused(s));
    for (int k = 0; k < 300; ++k) {
      read(true);
      LONGS_EQUAL(0, accused(s));
    }
    read(false);
    LONGS_EQUAL(kNoCell, accused(s));
  }
}
