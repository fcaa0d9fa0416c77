// SPDX-License-Identifier: Apache-2.0
// A node falls silent at full pedal: the torque goes, the contactors open, the run says why.
#include "bench.hpp"
#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

constexpr std::uint32_t kSilentAt_ms = 8000;  // after power-on: the car drives

void check_run_fails(std::uint32_t SilenceableLoop::*silent) {
  const EnduranceOptions options = nominal();
  SilenceableLoop loop(options.vehicle);
  loop.*silent = kSilentAt_ms;
  Record record;
  const EnduranceResult r = run_endurance(options, loop, record);
  CHECK_FALSE(r.finished);
  STRCMP_CONTAINS("left ready-to-drive", r.failure_cause.c_str());
  CHECK(r.failure_time_s > 0.0 && r.failure_time_s < kSilentAt_ms * 1e-3);
}

}  // namespace

TEST_GROUP(Silence) {
  LoopBench bench{vtm16e()};

  void setup() override { bench.drive_off(2.0); }
  /// The phase current is zero for good after `torque_ms`, both AIRs are open for good after `contactors_ms`.
  void check_stops(std::uint32_t torque_ms, std::uint32_t contactors_ms) {
    const std::uint32_t start = bench.now_ms();
    std::uint32_t torque_last = start, air_last = start;
    while (bench.now_ms() < start + 1000) {
      bench.tick();
      if (bench.car.phase_current_a() != 0.0) torque_last = bench.now_ms();
      if (bench.any_air_closed()) air_last = bench.now_ms();
    }
    CHECK(torque_last - start <= torque_ms);
    CHECK(air_last - start <= contactors_ms);
  }
};

TEST(Silence, TheBenchDrivesAtFullPedal) {
  CHECK(bench.commands.master().drive_state == can::DriveState::kReadyToDrive);
  CHECK(bench.car.phase_current_a() > 535.0);  // what the motor's curve allows, 80.8 to 82 Nm
  CHECK(bench.any_air_closed());
}

TEST(Silence, OfTheBmsEndsTheTorqueAndOpensTheContactorsInAQuarterOfASecond) {
  bench.loop.bms_silent_from_ms = bench.now_ms();
  check_stops(80, 250);
}

TEST(Silence, OfTheMasterEndsTheTorqueAndOpensTheContactorsInAQuarterOfASecond) {
  bench.loop.master_silent_from_ms = bench.now_ms();
  check_stops(80, 250);
}

TEST(Silence, OfBothNodesEndsTheTorqueAndOpensTheContactors) {
  bench.loop.bms_silent_from_ms = bench.loop.master_silent_from_ms = bench.now_ms();
  check_stops(80, 250);
}

TEST(Silence, OfNobodyButAnOpenShutdownCircuitOpensTheContactors) {
  bench.switches.shutdown_closed = false;
  check_stops(100, 250);
}

TEST(Silence, OfTheBmsFailsARunWithCauseAndTime) { check_run_fails(&SilenceableLoop::bms_silent_from_ms); }

TEST(Silence, OfTheMasterFailsARunWithCauseAndTime) { check_run_fails(&SilenceableLoop::master_silent_from_ms); }

TEST(Silence, OfTheBmsFromPowerOnNeverLetsTheCarGetReady) {
  const EnduranceOptions options = nominal();
  SilenceableLoop loop(options.vehicle);
  loop.bms_silent_from_ms = 0;
  Record record;
  const EnduranceResult r = run_endurance(options, loop, record);
  STRCMP_CONTAINS("did not become ready to drive within 20 s", r.failure_cause.c_str());
  CHECK(record.samples.empty());
}
