// SPDX-License-Identifier: Apache-2.0
#include "bms/estimate/soc_estimator.hpp"

#include "bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;

TEST_GROUP(SocEstimator) {
  Config config = pack_config();
  SocEstimate soc{};
  Sample<CellVoltage> cells[kMaxCells] = {};
  const Sample<Current> rest{Current{}, Instant{}, Quality::kGood};
  void setup() override {
    for (auto& cell : cells) cell = Sample<CellVoltage>{CellVoltage::from_raw(36'000), Instant{}, Quality::kGood};
  }
};

TEST(SocEstimator, MethodOfTheConfigurationIsUsed) {
  estimate_soc(config, SocInput{cells, true, rest}, soc);
  LONGS_EQUAL(500'000, soc.value.raw());
  CHECK(soc_ready(config, soc));
}

TEST(SocEstimator, NotReadyBeforeTheStart) { CHECK_FALSE(soc_ready(config, soc)); }

TEST(SocEstimator, NoneNeverKnowsAndNeverMakesWait) {
  config.soc_method = SocMethod::kNone;
  estimate_soc(config, SocInput{cells, true, rest}, soc);
  CHECK_FALSE(soc.valid);
  CHECK(soc_ready(config, soc));
}

TEST(SocEstimator, NoneForgetsWhatAnotherMethodKnew) {
  config.soc_method = SocMethod::kNone;
  soc.valid = true;
  soc.value = Soc::from_raw(700'000);
  estimate_soc(config, SocInput{cells, true, rest}, soc);
  CHECK_FALSE(soc.valid);
  LONGS_EQUAL(0, soc.value.raw());
}

TEST(SocEstimator, NoneForgetsWhatAnotherMethodHasCounted) {
  soc.value = Soc::from_raw(123);
  soc.charge = 456;
  soc.last_current = {Current::from_raw(7), Instant::from_ms(9), Quality::kGood};
  soc.valid = true;
  config.soc_method = SocMethod::kNone;
  estimate_soc(config, SocInput{cells, true, rest}, soc);
  CHECK_FALSE(soc.valid);
  LONGS_EQUAL(0, soc.value.raw());
  LONGS_EQUAL(0, soc.charge);
  CHECK_FALSE(soc.last_current.good());
  LONGS_EQUAL(0, soc.last_current.value.raw());
}
