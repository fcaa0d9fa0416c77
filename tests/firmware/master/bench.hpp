// SPDX-License-Identifier: Apache-2.0
// A healthy car as the master controller sees it, one step every 10 ms, and a finger in every sample.
#pragma once
#include "master/master_step.hpp"

namespace voltlap::master::bench {

inline constexpr std::int32_t kStepMs = 10;

template <class T>
Sample<T> good(T value, Instant now = Instant{}) {
  return Sample<T>{value, now, Quality::kGood};
}

/// Voltage of one channel at a travel in per mille.
inline Potential volts(const AppsChannel& channel, std::int32_t per_mille) {
  const std::int64_t span = (channel.full - channel.released).raw();
  return Potential::from_raw(channel.released.raw() + static_cast<std::int32_t>(span * per_mille / 1000));
}

inline void set_pedal(const Config& config, std::int32_t per_mille, Input& in) {
  in.apps1.value = volts(config.apps1, per_mille);
  in.apps2.value = volts(config.apps2, per_mille);
}

inline void set_brake(std::int32_t mbar, Input& in) {
  in.brake_front.value = Pressure::from_raw(mbar);
  in.brake_rear.value = Pressure::from_raw(mbar);
}

/// Released pedals, closed shutdown circuit, 90 V, standing still, generous limits, BMS idle.
inline Input healthy(const Config& config) {
  Input in;
  in.apps1 = good(config.apps1.released);
  in.apps2 = good(config.apps2.released);
  in.brake_front = in.brake_rear = good(Pressure{});
  for (Sample<Speed>& wheel : in.wheel_speed) wheel = good(Speed{});
  in.motor_speed = good(MotorSpeed{});
  in.dc_link_voltage = in.pack_voltage = good(PackVoltage::from_raw(900'000));
  in.inverter_state = good(InverterState::kDisabled);
  in.pack_current = good(Current{});
  in.discharge_limit = in.charge_limit = good(Current::from_raw(400'000));
  in.bms_state = good(BmsState::kIdle);
  in.switches = good(Switches{true, false, false, false});
  in.motor_temperature = in.inverter_temperature = good(Temperature::from_raw(400));
  return in;
}

/// Every good sample was taken now.
inline void touch_all(Input& in) {
  const Instant t = in.now;
  in.apps1.time = in.apps2.time = in.brake_front.time = in.brake_rear.time = t;
  for (Sample<Speed>& wheel : in.wheel_speed) wheel.time = t;
  in.motor_speed.time = in.dc_link_voltage.time = in.inverter_state.time = t;
  in.pack_voltage.time = in.pack_current.time = in.discharge_limit.time = in.charge_limit.time = t;
  in.bms_state.time = in.switches.time = in.motor_temperature.time = in.inverter_temperature.time = t;
}

/// The whole controller on samples.
struct Car {
  Config config{};
  Input in = healthy(config);
  State state{};
  Output out{};

  /// Steps with fresh samples; returns the last output.
  const Output& run(std::int32_t steps = 1) {
    for (std::int32_t i = 0; i < steps; ++i) {
      in.now = in.now + Duration::from_ms(kStepMs);
      touch_all(in);
      out = step(config, in, state);
    }
    return out;
  }
  void pedal(std::int32_t per_mille) { set_pedal(config, per_mille, in); }
  void brake(std::int32_t mbar) { set_brake(mbar, in); }

  void drive_to_ts_active() {
    run(2);
    in.switches.value.ts_on_button = true;
    run();
    in.switches.value.ts_on_button = false;
    in.bms_state.value = BmsState::kTsActive;
    run(2);
  }
  /// Ready to drive, ceilings risen, brake released again.
  void drive_to_ready() {
    drive_to_ts_active();
    run(40);
    brake(20'000);
    in.switches.value.rtd_button = true;
    run();
    in.switches.value.rtd_button = false;
    in.inverter_state.value = InverterState::kEnabled;
    brake(0);
    run(2);
  }
  /// Ready and at full pedal, request risen.
  void drive_at_full_pedal() {
    drive_to_ready();
    pedal(1000);
    run(5);
  }
};

}  // namespace voltlap::master::bench
