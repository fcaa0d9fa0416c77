// SPDX-License-Identifier: Apache-2.0
#include "bms/fault_timer.hpp"

#include "driven_bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;
using can::BmsFault;

TEST_GROUP(FaultTimer) {
  FaultTimer timer;
  const Duration tick = Duration::from_ms(10), time = Duration::from_ms(500);
  void steps(Seen condition, int n) {
    for (int i = 0; i < n; ++i) count(condition, tick, time, timer);
  }
};

// BMS-024
TEST(FaultTimer, CountsUpAndFourTimesSlowerDown) {
  steps(Seen::kActive, 41);
  LONGS_EQUAL(400'000, timer.level_us);
  steps(Seen::kClear, 40);
  LONGS_EQUAL(300'000, timer.level_us);
  CHECK_FALSE(timer.set);
  steps(Seen::kActive, 21);
  CHECK(timer.set);
}

// BMS-024
TEST(FaultTimer, UnknownGoesOnWithWhatWasLastKnownAndHoldStands) {
  steps(Seen::kActive, 11);
  steps(Seen::kUnknown, 10);
  LONGS_EQUAL(200'000, timer.level_us);
  steps(Seen::kHold, 100);
  LONGS_EQUAL(200'000, timer.level_us);
  steps(Seen::kClear, 4);
  steps(Seen::kUnknown, 100);
  LONGS_EQUAL(190'000, timer.level_us);
}

TEST(FaultTimer, AFaultWithoutATimeIsSetAndGoneInItsStep) {
  count(Seen::kActive, tick, Duration{}, timer);
  CHECK(timer.set);
  count(Seen::kClear, tick, Duration{}, timer);
  CHECK_FALSE(timer.set);
}

TEST(FaultTimer, ATimeThatRunsBackCountsNothing) {
  steps(Seen::kActive, 11);
  for (const Seen condition : {Seen::kActive, Seen::kUnknown, Seen::kClear}) {
    count(condition, Duration::from_ms(-1'000), time, timer);
    LONGS_EQUAL(100'000, timer.level_us);
  }
}

// What is idle is left alone, so a clear condition must change nothing in it.
TEST(FaultTimer, AnIdleTimerIsNotSetAndStaysAsItIs) {
  for (const std::int32_t ms : {0, 10, 500}) {
    timer = FaultTimer{};
    for (unsigned draw = 1; draw < 3'000; ++draw) {
      count(static_cast<Seen>(draw * 2'654'435'761U >> 30U), tick, Duration::from_ms(ms), timer);
      if (!idle(timer)) continue;
      CHECK_FALSE(timer.set);
      count(Seen::kClear, tick, Duration::from_ms(ms), timer);
      CHECK(idle(timer) && !timer.set);
    }
  }
}

TEST(FaultTimer, TheLongestTimeDoesNotOverflow) {
  for (int i = 0; i < 70'000; ++i) count(Seen::kActive, tick, kFaultTimeMax, timer);
  LONGS_EQUAL(600'000'000, timer.level_us);
  CHECK(timer.set);
  count(Seen::kActive, Duration::from_ms(2'000'000'000), kFaultTimeMax, timer);
  LONGS_EQUAL(600'000'000, timer.level_us);
}

// BMS-024
TEST(FaultTimer, IntermittentFaultTripsInTheEnd) {
  Bench bench;
  bench.drive();
  std::int32_t took = 0;
  for (; took < 20'000 && !has(bench.out, BmsFault::kDischargeCurrentHigh); took += 10) {
    bench.current(amps(took % 600 < 300 ? 601.0 : 500.0));  // half of the time; 1 s of it trips
    bench.tick();
  }
  expect_time("BMS-024 half of the time", took, 1'000, 2'800);
}

// BMS-024
TEST(FaultTimer, FaultForATenthOfTheTimeDoesNotTrip) {
  Bench bench;
  bench.drive();
  for (std::int32_t t = 0; t < 60'000; t += 10) {
    bench.current(amps(t % 1000 < 100 ? 601.0 : 500.0));
    CHECK_FALSE(has(bench.tick(), BmsFault::kDischargeCurrentHigh));
  }
}

// BMS-024
TEST(FaultTimer, CellThatIsLostAgainAndAgainTrips) {
  Bench bench;
  bench.drive();
  std::int32_t took = 0;
  for (; took < 20'000 && !has(bench.out, BmsFault::kCellMeasurementLost); took += 10) {
    bench.invalid_cells.clear();
    if (took % 480 < 360) bench.invalid_cells.insert(4);  // a good sample now and then
    bench.tick();
  }
  expect_time("BMS-024 lost again and again", took, 1'000, 2'500);
}
