// SPDX-License-Identifier: Apache-2.0
// The pedal box of a run is the one that its master controller is configured for.
#include <algorithm>

#include "apps/firmware_config.hpp"
#include "fixtures.hpp"
#include "loop.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

/// The lowest and the highest voltage of both sensors on the bus [V].
struct PedalWatch : Record {
  void on_frame(std::uint32_t, Sender, const Frame& frame) override {
    can::Pedals m;
    if (!can::decode(frame, m)) return;
    low1_v = std::min(low1_v, m.apps1_100uv * 1e-4);
    high1_v = std::max(high1_v, m.apps1_100uv * 1e-4);
    low2_v = std::min(low2_v, m.apps2_100uv * 1e-4);
    high2_v = std::max(high2_v, m.apps2_100uv * 1e-4);
  }
  double low1_v = 9.0, high1_v = 0.0, low2_v = 9.0, high2_v = 0.0;
};

}  // namespace

TEST_GROUP(PedalSensors) {
  EnduranceOptions options = nominal();
  master::Config config = master_config(options.vehicle);
  PedalWatch watch;

  void setup() override {
    options.drive = RecordedDrive{"short", {0.0, 6.0, 9.0, 11.0}, {0.0, 20.0, 20.0, 2.0}, {}, {}};
    // A second sensor that reads from 1 to 4 V, and a first that starts at 0.8 V.
    config.apps1.released = Potential::from_raw(8'000);
    config.apps2 = {Potential::from_raw(10'000), Potential::from_raw(40'000), Potential::from_raw(6'000),
                    Potential::from_raw(44'000)};
  }
  EnduranceResult race() {
    FirmwareLoop firmware(bms_config(options.vehicle), config);
    return run_endurance(options, firmware, watch);
  }
};

TEST(PedalSensors, FollowTheMastersConfigurationAndTheCarDrives) {
  const EnduranceResult before = drive(options);
  options.pedal_sensors = pedal_sensors(config);
  const EnduranceResult r = race();
  STRCMP_EQUAL("", r.failure_cause.c_str());
  CHECK(r.finished);
  DOUBLES_EQUAL(0.8, watch.low1_v, 1e-3);
  DOUBLES_EQUAL(1.0, watch.low2_v, 1e-3);
  DOUBLES_EQUAL((watch.high1_v - 0.8) / 3.7, (watch.high2_v - 1.0) / 3.0, 1e-3);
  CHECK(watch.high1_v > 2.0);
  // The same road with the same pedal: what differs is the rounding on the wire.
  DOUBLES_EQUAL(before.distance_m, r.distance_m, 0.01 * before.distance_m);
  DOUBLES_EQUAL(before.max_speed_mps, r.max_speed_mps, 0.1);
}

TEST(PedalSensors, OfAnotherMasterLeaveTheCarStanding) {
  const EnduranceResult r = race();
  CHECK_FALSE(r.finished);
  STRCMP_CONTAINS("did not become ready to drive", r.failure_cause.c_str());
}
