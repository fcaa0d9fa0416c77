// SPDX-License-Identifier: Apache-2.0
#include "master/command_veto.hpp"

#include "CppUTest/TestHarness.h"
#include "firmware/master/bench.hpp"

using namespace voltlap;
using namespace voltlap::master;

TEST_GROUP(CommandVeto) {
  Config config{};
  Input in = bench::healthy(config);
  InverterCommand command{Current::from_raw(100'000), true};

  void setup() override {
    in.bms_state.value = BmsState::kTsActive;
    bench::set_pedal(config, 500, in);
    in.now = Instant::from_ms(1'000);
    bench::touch_all(in);
  }
  bool allows() { return command_allowed(config, in, command); }
};

TEST(CommandVeto, HealthyCommandPasses) { CHECK(allows()); }

TEST(CommandVeto, DisabledZeroPassesAlwaysAndDisabledCurrentNever) {
  command = InverterCommand{};
  CHECK(command_allowed(config, Input{}, command));
  command.phase_current = Current::from_raw(100);
  CHECK_FALSE(allows());
}

TEST(CommandVeto, AllZeroInputIsVetoed) { CHECK_FALSE(command_allowed(config, Input{}, command)); }

// MST-050
TEST(CommandVeto, SampleOf49MsPassesAndOf50MsIsVetoed) {
  in.now = Instant::from_ms(1'049);
  CHECK(allows());
  in.now = Instant::from_ms(1'050);
  CHECK_FALSE(allows());
}

// MST-050
TEST(CommandVeto, EveryInputThatCarriesTorqueIsCheckedOnItsOwn) {
  const Instant old = Instant::from_ms(950);
  Instant* const times[] = {&in.apps1.time,     &in.apps2.time,           &in.inverter_state.time, &in.switches.time,
                            &in.bms_state.time, &in.discharge_limit.time, &in.charge_limit.time};
  for (Instant* time : times) {
    *time = old;
    CHECK_FALSE(allows());
    *time = in.now;
    CHECK(allows());
  }
}

// MST-050
TEST(CommandVeto, SampleOfTheFutureIsVetoedAndTheWrapOfTimeIsNot) {
  in.apps1.time = Instant::from_ms(1'001);
  CHECK_FALSE(allows());
  in.now = Instant::from_ms(0xFFFFFFF0U);
  bench::touch_all(in);
  in.now = Instant::from_ms(5);  // 21 ms later
  CHECK(allows());
}

// MST-050
TEST(CommandVeto, QualityOtherThanGoodIsVetoed) {
  for (const Quality q : {Quality::kNone, Quality::kInvalid, Quality::kStale}) {
    in.discharge_limit.quality = q;
    CHECK_FALSE(allows());
  }
}

// MST-051
TEST(CommandVeto, CurrentOneStepBeyondTheInverterIsVetoed) {
  command.phase_current = config.phase_current_max;
  CHECK(allows());
  command.phase_current = config.phase_current_max + Current::from_raw(1);
  CHECK_FALSE(allows());
  command.phase_current = -config.phase_current_max;
  CHECK(allows());
  command.phase_current = -config.phase_current_max - Current::from_raw(1);
  CHECK_FALSE(allows());
}

// MST-051
TEST(CommandVeto, ClosedBatteryIsVetoedInItsDirectionOnly) {
  in.discharge_limit.value = Current{};
  CHECK_FALSE(allows());
  command.phase_current = Current::from_raw(-100'000);
  CHECK(allows());
  in.charge_limit.value = Current{};
  CHECK_FALSE(allows());
  command.phase_current = Current{};
  CHECK(allows());
}

// MST-051
TEST(CommandVeto, DriveCurrentWithEitherSensorReleasedIsVetoed) {
  in.apps2.value = config.apps2.released;
  CHECK_FALSE(allows());
  in.apps2.value = config.apps2.released + Potential::from_raw(1);
  CHECK(allows());
  in.apps1.value = config.apps1.released;
  CHECK_FALSE(allows());
}

TEST(CommandVeto, OpenShutdownCircuitOrBmsNotActiveIsVetoed) {
  in.switches.value.shutdown_closed = false;
  CHECK_FALSE(allows());
  in.switches.value.shutdown_closed = true;
  in.bms_state.value = BmsState::kOpen;
  CHECK_FALSE(allows());
}

// MST-051, MST-064
TEST(CommandVeto, APm100IsSentNoTorqueBeyondItsLimitNorALimitBeyondTheInverter) {
  config.inverter_protocol = InverterProtocol::kPm100;
  command.limit = command.phase_current;
  CHECK(allows());
  command.limit = command.phase_current - Current::from_raw(1);
  CHECK_FALSE(allows());
  command.limit = config.phase_current_max;
  CHECK(allows());
  command.limit = config.phase_current_max + Current::from_raw(1);
  CHECK_FALSE(allows());
  command.phase_current = Current::from_raw(-100'000);
  command.limit = Current::from_raw(99'999);
  CHECK_FALSE(allows());
  command.limit = Current::from_raw(100'000);
  CHECK(allows());
}

// MST-051, MST-069: braking as driving, at the last step that a motor may have and one beyond.
TEST(CommandVeto, FourCurrentsAreHeldToTheirMotorsAndTheirDirection) {
  config.inverter_protocol = InverterProtocol::kAmk;
  config.motor_current_max = Current::from_raw(40'000);
  in.inverter_state.value = InverterState::kEnabled;
  const auto allows_four = [&](std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) {
    command.wheel = {{Current::from_raw(a), Current::from_raw(b), Current::from_raw(c), Current::from_raw(d)}};
    command.phase_current = command.wheel.sum();
    return allows();
  };
  for (const std::int32_t sign : {1, -1}) {
    CHECK(allows_four(sign * 40'000, 0, sign * 40'000, sign * 40'000));
    CHECK_FALSE(allows_four(sign * 40'000, 0, sign * 40'001, sign * 40'000));
    CHECK_FALSE(allows_four(sign * 40'000, sign * -1, sign * 40'000, sign * 40'000));
    command.phase_current = command.phase_current + Current::from_raw(1);
    CHECK_FALSE(allows());
  }
  CHECK(allows_four(0, 0, 0, 0));
  CHECK_FALSE(allows_four(1, -1, 0, 0));
  CHECK_FALSE(allows_four(-1, 1, 0, 0));
  in.inverter_state.value = InverterState::kDisabled;
  CHECK(allows_four(0, 0, 0, 0));
  CHECK_FALSE(allows_four(1, 1, 1, 1));
}
