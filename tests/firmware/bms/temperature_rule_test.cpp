// SPDX-License-Identifier: Apache-2.0
// The two rules of BMS-064 on both sides of their bounds.
#include "bms/temperature_check.hpp"
#include "bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;

TEST_GROUP(TemperatureRule) {
  Config config = pack_config();
  State s;
  TemperatureCheck& c = s.temperature_check;
  void setup() override {
    for (std::size_t i = 0; i < kMaxTemperatures; ++i) read(i, 250, 0);
    check(0);
  }
  void read(std::size_t i, std::int32_t dc, std::uint32_t ms) {
    s.measured.temperature[i] = {Temperature::from_raw(dc), Instant::from_ms(ms), Quality::kGood};
  }
  void check(std::uint32_t ms) {
    s.measured.temperatures_arrived = true;
    check_temperatures(config, Instant::from_ms(ms), s);
  }
};

// BMS-064: 8 K from the mean of 5 s, which has followed a fiftieth in 100 ms and a sixth in 1 s.
TEST(TemperatureRule, AReadingEightKelvinFromItsOwnMeanIsTooFastEitherWay) {
  struct Case {
    std::uint32_t ms;
    std::int32_t most_dc;
  };
  for (const Case& x : {Case{100, 81}, Case{1'000, 95}}) {
    for (const std::int32_t sign : {-1, 1}) {
      s = State{};
      setup();
      read(4, 250 + sign * x.most_dc, x.ms);
      check(x.ms);
      LONGS_EQUAL(kNoCell, c.too_fast);
      s = State{};
      setup();
      read(4, 250 + sign * (x.most_dc + 2), x.ms);
      check(x.ms);
      LONGS_EQUAL(4, c.too_fast);
    }
  }
}

// BMS-064
TEST(TemperatureRule, ExactlyEightKelvinAreNotTooFast) {
  for (const std::int32_t more : {0, 1}) {
    c.sensor[4].slow = 256 * (250 - 80) - more;
    check(0);  // no time has passed
    LONGS_EQUAL(more == 1 ? 4 : kNoCell, c.too_fast);
  }
}

// BMS-064
TEST(TemperatureRule, AFastSensorIsToldUntilItIsReadAgainAndHasCalmed) {
  read(4, 350, 100);
  check(100);
  LONGS_EQUAL(4, c.too_fast);
  read(3, 250, 200);
  check(200);
  LONGS_EQUAL(4, c.too_fast);  // another one calms nothing
  read(4, 255, 300);
  check(310);
  LONGS_EQUAL(4, c.too_fast);  // nor does a reading that is not of this step
  read(4, 255, 400);
  s.measured.temperatures_arrived = false;
  check_temperatures(config, Instant::from_ms(400), s);
  LONGS_EQUAL(4, c.too_fast);
  check(400);
  LONGS_EQUAL(kNoCell, c.too_fast);
}

// BMS-064
TEST(TemperatureRule, AReadingIsJudgedOnceByTheTimeSinceTheLastOne) {
  read(4, 345, 1'000);
  check(1'000);
  LONGS_EQUAL(kNoCell, c.too_fast);
  const std::int32_t slow = c.sensor[4].slow;
  DOUBLES_EQUAL(256 * (250 + 95 / 6.0), slow, 2.0);
  check(1'010);
  LONGS_EQUAL(slow, c.sensor[4].slow);
  read(4, 345, 1'100);
  check(1'100);
  DOUBLES_EQUAL(256 * (250 + 95 / 6.0 + 95 * 5 / 6.0 / 51.0), c.sensor[4].slow, 3.0);
}

// BMS-064
TEST(TemperatureRule, AReadingTwentyFiveKelvinFromTheMeanOfTheOthersIsApartEitherWay) {
  for (const std::uint16_t sensors : {std::uint16_t{3}, std::uint16_t{6}}) {
    config.temperature_sensors = sensors;
    for (const std::uint16_t i : {std::uint16_t{0}, std::uint16_t{1}, static_cast<std::uint16_t>(sensors - 1)}) {
      for (const std::int32_t away : {-251, -250, 250, 251}) {
        read(i, 250 + away, 0);
        check(500);
        LONGS_EQUAL(away < -250 || away > 250 ? i : kNoCell, c.apart);
        read(i, 250, 0);
        check(500);
        LONGS_EQUAL(kNoCell, c.apart);
      }
    }
  }
  config.temperature_sensors = 2;
  read(1, 750, 0);
  check(500);
  LONGS_EQUAL(kNoCell, c.apart);  // of two none is the wrong one
}

// BMS-064
TEST(TemperatureRule, ASensorThatIsLostHasNoPartInTheMeanAndIsNotApart) {
  read(0, 900, 0);
  read(1, 501, 0);
  s.measured.temperature[0].quality = Quality::kStale;
  check(500);
  LONGS_EQUAL(1, c.apart);
  read(1, 500, 0);
  check(500);
  LONGS_EQUAL(kNoCell, c.apart);
  read(1, 600, 0);
  for (const std::size_t i : {2, 3, 4}) s.measured.temperature[i].quality = Quality::kInvalid;
  check(500);
  LONGS_EQUAL(kNoCell, c.apart);  // two are left
  s.measured.temperature[2].quality = Quality::kGood;
  check(500);
  LONGS_EQUAL(1, c.apart);
}
