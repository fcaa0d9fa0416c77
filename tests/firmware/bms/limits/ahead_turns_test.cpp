// SPDX-License-Identifier: Apache-2.0
// Which cells a step looks at, for which horizon, and what it does in which step.
#include "limits/ahead_bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;

namespace {

constexpr std::int32_t kOld = 900'000'000;  // beyond any maximum: the least is one that has been looked at

}  // namespace

TEST_GROUP_BASE(AheadTurns, AheadBench) {
  void started() {
    for (TrueCell& cell : cells) cell.soc = 0.5;
    for (int tick = 0; tick < 12; ++tick) step(0.0);
    forget();
  }
  void forget() {
    for (CellAhead& cell : state.ahead.cell) {
      for (std::int32_t& ma : cell.discharge) ma = kOld;
      for (std::int32_t& ma : cell.charge) ma = kOld;
    }
  }
  /// Three of the 24 cells have just had their turn, the last of them before `next`.
  void look(std::uint32_t step, std::uint16_t next = 6) {
    state.steps = step;
    state.soc.filter.next = next;
    look_ahead(config, state);
  }
  bool out(std::size_t cell, std::size_t horizon) const { return state.ahead.cell[cell].discharge[horizon] != kOld; }
  bool in(std::size_t cell, std::size_t horizon) const { return state.ahead.cell[cell].charge[horizon] != kOld; }
  /// A whole round of the cells beside, of one direction of one horizon and of nothing else.
  void round_of(std::size_t horizon, bool discharge, std::size_t binding) {
    forget();
    for (std::size_t turn = 0; turn < 8; ++turn) {
      LONGS_EQUAL(2 * horizon + (discharge ? 0 : 1), state.ahead.other);
      LONGS_EQUAL(3 * turn, state.ahead.other_cell);
      look(11);
      for (std::size_t k = 0; k < 24; ++k) {
        for (std::size_t h = 0; h < kLimitHorizonCount; ++h) {
          if (h == binding) continue;
          const bool looked = h == horizon && k < 3 * turn + 3;
          CHECK_EQUAL(looked && discharge, out(k, h));
          CHECK_EQUAL(looked && !discharge, in(k, h));
        }
      }
    }
    LONGS_EQUAL(0, state.ahead.other_cell);
  }
};

// BMS-045
TEST(AheadTurns, TheHorizonsThatDoNotLimitTakeTurnsOneDirectionAtATime) {
  started();
  state.ahead.other = 2;
  state.ahead.other_cell = 0;
  for (const std::size_t horizon : {1U, 2U, 3U, 1U}) {
    round_of(horizon, true, 0);
    round_of(horizon, false, 0);
  }
  config.limit_horizon = kLimitHorizons[1];
  state.ahead.other = 6;
  for (const std::size_t horizon : {3U, 0U, 2U}) {
    round_of(horizon, true, 1);
    round_of(horizon, false, 1);
  }
  config.limit_horizon = kLimitHorizons[3];
  for (const std::size_t horizon : {0U, 1U, 2U, 0U}) {
    if (horizon == 0) state.ahead.other = 0;
    round_of(horizon, true, 3);
    round_of(horizon, false, 3);
  }
}

// BMS-045
TEST(AheadTurns, WhenTheHorizonThatLimitsHasItsTurnBesideTheNextOneTakesIt) {
  started();
  state.ahead.other = 1;
  look(10);
  LONGS_EQUAL(2, state.ahead.other);
  config.limit_horizon = kLimitHorizons[2];
  state.ahead.other = 4;
  look(10);
  LONGS_EQUAL(6, state.ahead.other);
  look(10);
  LONGS_EQUAL(6, state.ahead.other);
}

// BMS-045
TEST(AheadTurns, TheCellsWhoseFilterHasJustBeenSteppedAreLookedAt) {
  started();
  state.soc.filter.cell[20].filter.s = kUnit / 5;  // the one that limits, once it is known
  for (const std::uint16_t next : {std::uint16_t{6}, std::uint16_t{1}}) {
    forget();
    look(10, next);
    for (std::size_t k = 0; k < 24; ++k) {
      const bool turn = (k + 3) % 24 == next || (k + 2) % 24 == next || (k + 1) % 24 == next;
      CHECK_EQUAL(turn, out(k, 0));
      CHECK_EQUAL(turn, in(k, 0));
    }
  }
}

// BMS-045
TEST(AheadTurns, TheCellThatLimitsTheDischargeIsLookedAtInBothDirections) {
  started();
  state.ahead.cell[15].discharge[0] = 1;
  look(10);
  CHECK(state.ahead.cell[15].discharge[0] > 1'000 && out(15, 0) && in(15, 0));
  CHECK(!out(14, 0) && !in(14, 0) && !out(16, 0) && !in(16, 0));
}

// BMS-045
TEST(AheadTurns, TheOthersWaitInTheFirstLookAndInEveryTenthStepWhichReadsWhatHeatChanges) {
  started();
  const PartFactors change = heat_change(state.soc.filter);
  CHECK(change.r0 != 0);
  const auto beside = [&](bool began, std::uint32_t step) {
    state.ahead.began = began;
    state.ahead.other = 2;
    state.ahead.other_cell = 0;
    state.ahead.heat = {0, 0, 0, 0, 0};
    look(step);
    CHECK(state.ahead.began);
    const bool read = state.ahead.heat.r0 == change.r0;
    CHECK_EQUAL(read, state.ahead.heat.r0 != 0);
    CHECK_EQUAL(read, state.ahead.other_cell == 0);
    return !read;
  };
  CHECK(!beside(false, 10) && !beside(false, 11));
  CHECK(!beside(true, 10) && beside(true, 11) && beside(true, 12) && beside(true, 19) && !beside(true, 20));
}

TEST(AheadTurns, TheMeanOfTheResistancesIsTakenWhenTheLastCellHasHadItsTurn) {
  started();
  for (std::size_t k = 0; k < 24; ++k) state.soc.filter.cell[k].filter.rho = kUnit;
  state.soc.filter.cell[5].filter.rho -= 1;  // and rounded down
  for (std::uint16_t next = 0; next < 24; ++next) {
    state.ahead.scale = 7;
    look(11, next);
    LONGS_EQUAL(next < 3 ? kUnit - 1 : 7, state.ahead.scale);
  }
}

// BMS-045
TEST(AheadTurns, OfCellsThatCanDoTheSameTheFirstIsNamed) {
  for (std::size_t k = 0; k < 24; ++k) state.ahead.cell[k].discharge[1] = state.ahead.cell[k].charge[2] = 5'000;
  LONGS_EQUAL(0, ahead_limit(config, state, Direction::kDischarge, 1).cell);
  state.ahead.cell[0].discharge[1] = 4'999;
  state.ahead.cell[9].charge[2] = 4'999;
  LONGS_EQUAL(0, ahead_limit(config, state, Direction::kDischarge, 1).cell);
  LONGS_EQUAL(4'999, ahead_limit(config, state, Direction::kDischarge, 1).value.raw());
  LONGS_EQUAL(9, ahead_limit(config, state, Direction::kCharge, 2).cell);
}

// BMS-045
TEST(AheadTurns, AHorizonThatIsNoneOfTheKnownIsForEver) {
  started();
  config.limit_horizon = Duration::from_ms(5'000);
  for (std::uint16_t next = 0; next < 24; next += 3) look(10, next);
  for (std::size_t k = 0; k < 24; ++k) CHECK(out(k, 3) && in(k, 3) && !out(k, 2) && !in(k, 2));
  LONGS_EQUAL(discharge(3).raw(), discharge_ceiling(config, state).value.raw());
}

TEST(AheadTurns, ACellHasWarmedAsTheColdestThermistorHasOnceThatIsKnown) {
  SocFilter& filter = state.soc.filter;
  filter.heat_known = true;
  filter.heat_began = Temperature::from_raw(200);
  filter.heat_of = Temperature::from_raw(230);
  state.ahead.scale = kUnit;
  filter.cell[2].filter.rho = 3 * kUnit;
  const auto warmer = [&](std::int32_t coldest) {
    state.pack.temperature_min = Temperature::from_raw(coldest);
    return own_warmth(state, 2);
  };
  LONGS_EQUAL(0, warmer(200));
  LONGS_EQUAL(3 - 30, warmer(201));
  LONGS_EQUAL(30, warmer(220));
  state.ahead.scale = 1;  // any that is there
  LONGS_EQUAL(80 - 30, warmer(220));
  filter.heat_known = false;
  LONGS_EQUAL(0, warmer(220));
}
