// SPDX-License-Identifier: Apache-2.0
#include "bms/estimate/resistance.hpp"

#include "bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;

TEST_GROUP(CellResistance) {
  ResistanceTable table{};
  SocEstimate soc{};
  void setup() override {
    table.count = 3;
    table.soc[1] = Soc::from_raw(500'000);
    table.soc[2] = Soc::from_raw(1'000'000);
    table.resistance[0] = Resistance::from_raw(4'000);
    table.resistance[1] = Resistance::from_raw(2'000);
    table.resistance[2] = Resistance::from_raw(3'000);
    table.ppm_per_kelvin = -10'000;
    soc.valid = true;
  }
  std::int32_t at(std::int32_t soc_ppm, std::int32_t temperature_dc) {
    soc.value = Soc::from_raw(soc_ppm);
    return cell_resistance(table, soc, Temperature::from_raw(temperature_dc)).raw();
  }
};

TEST(CellResistance, IsInterpolatedOverStateOfCharge) {
  LONGS_EQUAL(4'000, at(0, 250));
  LONGS_EQUAL(3'000, at(250'000, 250));
  LONGS_EQUAL(2'000, at(500'000, 250));
  LONGS_EQUAL(2'500, at(750'000, 250));
}

TEST(CellResistance, RisesInTheColdAndFallsInTheHeat) {
  LONGS_EQUAL(2'200, at(500'000, 150));
  LONGS_EQUAL(1'800, at(500'000, 350));
}

TEST(CellResistance, StaysWithinAFifthAndFiveTimesOfTheTable) {
  LONGS_EQUAL(400, at(500'000, 1'500));
  table.ppm_per_kelvin = -100'000;
  LONGS_EQUAL(10'000, at(500'000, -400));
}

TEST(CellResistance, WithoutStateOfChargeTheHighestOfTheTableStands) {
  soc.valid = false;
  LONGS_EQUAL(4'000, at(500'000, 250));
}

TEST(CellResistance, TheHighestIsFoundWhereverItStandsAndNotBeyondTheTablesEnd) {
  soc.valid = false;
  table.resistance[3] = Resistance::from_raw(9'000);
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) table.resistance[k] = Resistance::from_raw(k == i ? 5'000 : 1'000);
    LONGS_EQUAL(5'000, at(500'000, 250));
  }
}
