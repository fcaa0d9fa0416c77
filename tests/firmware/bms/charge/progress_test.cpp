// SPDX-License-Identifier: Apache-2.0
// A charge ends, whatever moves to and fro, and balancing takes no more than it brings.
#include "bms/charge/progress.hpp"

#include <cstdlib>
#include <random>
#include <string>

#include "charge_bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;
using can::ChargePhase;
using can::ChargeReason;

namespace {

constexpr std::int32_t kHour = 3'600'000;

bool over(const Output& o) { return o.charge.phase == ChargePhase::kFull || o.charge.phase == ChargePhase::kStopped; }

std::uint64_t drawn_seed() {
  const char* given = std::getenv("VOLTLAP_TEST_SEED");
  return given != nullptr ? std::strtoull(given, nullptr, 10) : std::random_device{}();
}

double lowest(const std::vector<ChargeBench::Cell>& cells) {
  double least = 2.0;
  for (const auto& cell : cells) least = std::min(least, cell.soc);
  return least;
}

}  // namespace

TEST_GROUP(ChargeProgress){};

// BMS-056
TEST(ChargeProgress, DrawnDrainsThatTakeWhatIsChargedEndItFullOrByName) {
  const std::uint64_t seed = drawn_seed();
  std::mt19937_64 random(seed);
  for (int k = 0; k < 4; ++k) {
    const std::string told = "VOLTLAP_TEST_SEED=" + std::to_string(seed) + " draw " + std::to_string(k);
    Config config = charge_config();
    config.charge_current_end = Current::from_raw(100 * std::uniform_int_distribution(1, 5)(random));
    ChargeBench charger(config, std::uniform_real_distribution(0.96, 0.975)(random));
    charger.charge();
    // What flows besides has the size of a step or some, so that the hold goes on and off about it.
    charger.flows_besides_a = -std::uniform_real_distribution(0.0, 0.9)(random);
    charger.gives_at_most_a = std::uniform_real_distribution(0.3, 30.0)(random);
    CHECK_TEXT(charger.until(over, 40 * kHour) >= 0, told.c_str());
    CHECK_TEXT(charger.phase() == ChargePhase::kFull || charger.reason() != ChargeReason::kNone, told.c_str());
    CHECK_TEXT(charger.highest_v < 4.2, told.c_str());
  }
}

// BMS-056
TEST(ChargeProgress, AChargerWhoseCurrentTheLoadTakesIsNamedAfterTenMinutes) {
  ChargeBench charger(charge_config(), 0.5);
  charger.charge();
  charger.gives_at_most_a = 0.5;
  charger.flows_besides_a = -0.47;
  const std::int32_t took = charger.until_phase(ChargePhase::kStopped, 2 * kHour);
  CHECK(took > 0 && took <= 1'200'000);
  CHECK(charger.reason() == ChargeReason::kNoCurrent);
}

// BMS-056
TEST(ChargeProgress, CellsThatStayTooHotEndItAfterAnHour) {
  ChargeBench charger(charge_config(), 0.5);
  charger.charge();
  for (int dc = 250; dc <= 560; dc += 5) {
    for (auto& t : charger.bench.temperature_dc) t = dc;
    charger.run(5'000);
  }
  CHECK(charger.phase() == ChargePhase::kCharging && charger.reason() == ChargeReason::kTemperature);
  const std::int32_t took = charger.until_phase(ChargePhase::kStopped, 2 * kHour);
  CHECK(took > kHour / 2 && took <= kHour + 1'300'000);
  CHECK(charger.reason() == ChargeReason::kTemperature);
}

// BMS-056
TEST(ChargeProgress, FiveQuartersOfTheCapacityEndItWhateverGrows) {
  const Config config = charge_config();
  State state;
  state.charge.progress.total = std::int64_t{config.capacity_mah} * kHour / 4 * 5;
  CHECK(judge_progress(config, Instant{}, state) == Gain::kSome);
  ++state.charge.progress.total;
  CHECK(judge_progress(config, Instant{}, state) == Gain::kNone);
  state.charge.progress.reached = true;
  CHECK(judge_progress(config, Instant{}, state) == Gain::kFull);
}

// BMS-056
TEST(ChargeProgress, CellsThatTakeForEverAreChargedNoMoreThanFiveQuarters) {
  ChargeBench charger(charge_config(), 0.3);
  for (auto& cell : charger.cells) cell.capacity = 10.0;
  charger.charge();
  CHECK(charger.until_phase(ChargePhase::kStopped, 2 * kHour) >= 0);
  DOUBLES_EQUAL(0.3 + 1.25 / 10.0, charger.cells[0].soc, 0.001);
  CHECK(charger.reason() == ChargeReason::kNoCurrent);
}

// BMS-058
TEST(ChargeProgress, ThreeHoursOfShuntsWithoutComingNearerAreEnough) {
  const auto spread = [](std::int32_t v) { return CellVoltage::from_raw(v); };
  for (const std::int32_t nearer : {14, 15}) {  // 1.5 mV begin anew
    Charge charge;
    CHECK(come_nearer(spread(200), charge));
    charge.bled_ms = 3 * kHour - 1;
    CHECK(come_nearer(spread(200 - nearer), charge));
    charge.bled_ms = 3 * kHour;
    CHECK_EQUAL(nearer == 15, come_nearer(spread(200 - nearer), charge));
    charge.bled_ms = 6 * kHour - 1;
    CHECK_FALSE(come_nearer(spread(200 - nearer), charge));
  }
}

// BMS-058
TEST(ChargeProgress, ACellThatLosesWhatAShuntTakesIsNamedAndThePackIsLeftFull) {
  ChargeBench charger(charge_config(), 0.98);
  charger.cells[11].soc = 0.94;
  charger.charge();
  const auto leaks = [&](const Output& o) {
    if (charger.bench.out.charge.phase != ChargePhase::kWaiting) charger.cells[11].soc -= 0.2 * 0.01 / 36'000.0;
    return over(o);
  };
  CHECK(charger.until(leaks, 24 * kHour) >= 0);
  CHECK(charger.reason() == ChargeReason::kUneven);
  CHECK(charger.bench.out.suspect == 11 && charger.bench.out.suspect_why == can::SuspectWhy::kUneven);
  CHECK(charger.bench.state.charge.bled_ms < 4 * kHour);
  for (std::size_t i = 0; i < 24; ++i) CHECK(i == 11 || charger.cells[i].soc > 0.985);
}

// BMS-057
TEST(ChargeProgress, DrawnPacksAreBledNoDeeperThanTheirLowestCell) {
  const std::uint64_t seed = drawn_seed();
  std::mt19937_64 random(seed);
  for (int k = 0; k < 2; ++k) {
    const std::string told = "VOLTLAP_TEST_SEED=" + std::to_string(seed) + " draw " + std::to_string(k);
    ChargeBench charger(charge_config(), 0.96);
    for (auto& cell : charger.cells) {
      cell.soc += std::uniform_real_distribution(-0.002, 0.002)(random);
      cell.capacity = std::uniform_real_distribution(0.98, 1.02)(random);
    }
    charger.cells[5].drift_v = std::uniform_real_distribution(-0.005, 0.005)(random);
    charger.charge();
    CHECK_TEXT(charger.until_phase(ChargePhase::kResting, 4 * kHour) >= 0, told.c_str());
    const double least = lowest(charger.cells);
    double deepest = 2.0;
    const auto look = [&](const Output& o) {
      deepest = std::min(deepest, lowest(charger.cells));
      return over(o);
    };
    CHECK_TEXT(charger.until(look, 40 * kHour) >= 0, told.c_str());
    CHECK_TEXT(deepest > least - 0.02, told.c_str());  // 10 mV, a drift and a bleed of 1.2 V a charge
    CHECK_TEXT(charger.phase() == ChargePhase::kFull || charger.reason() != ChargeReason::kNone, told.c_str());
  }
}

// BMS-089
TEST(ChargeProgress, TheCountIncludesWhatTheShuntsTook) {
  ChargeBench charger(charge_config(), 0.97);
  for (std::size_t i = 1; i < 24; ++i) charger.cells[i].soc = 0.985;
  charger.charge();
  CHECK(charger.until_phase(ChargePhase::kBleeding, 4 * kHour) >= 0);
  charger.run(kHour / 2);
  CHECK(charger.until_phase(ChargePhase::kResting, 300'000) >= 0);
  CHECK(charger.until([](const Output& o) { return o.charge.phase != ChargePhase::kResting; }, 300'000) >= 0);
  charger.run(20);
  double mean = 0.0;
  for (const auto& cell : charger.cells) mean += cell.soc / 24.0;
  DOUBLES_EQUAL(mean, 1e-6 * charger.bench.out.soc.raw(), 0.003);
}

// BMS-059
TEST(ChargeProgress, NothingIsAskedOfAChargerAtTheStartOfTheDerating) {
  ChargeBench charger(charge_config(), 0.5);
  charger.charge();
  double last_a = 1e9;
  for (int dc = 250; dc <= 550; dc += 5) {
    for (auto& t : charger.bench.temperature_dc) t = dc;
    charger.run(5'000);
    const double asked_a = 1e-3 * charger.bench.out.charge.asked.raw();
    if (dc > 450) CHECK_TEXT(asked_a <= last_a + 0.1, "more is asked of warmer cells");
    last_a = asked_a;
  }
  DOUBLES_EQUAL(0.0, last_a, 0.0);
}
