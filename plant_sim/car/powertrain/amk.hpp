// SPDX-License-Identifier: Apache-2.0
// The logic in an AMK inverter between its CAN setpoints and its current controller: what it obeys, in which order it
// is switched on, and what ends that.
//
//   DcOn asked, DC link charged                 -> QuitDcOn, DcOn
//   Enable and InverterOn asked, setpoints zero -> QuitInverterOn, InverterOn; from now on setpoints are obeyed
//   T = clamp(k (n_target - n), T_negative, T_positive)      a speed controller between two torque limits
// An error, silence of the setpoints among them, ends all of it until ErrorReset comes with zero setpoints. Error
// numbers are the simulation's own. By the maker's Formula Student kit, as docs/inverters.md tells it.
#pragma once
#include <algorithm>
#include <cstdint>

#include "core/parameters.hpp"

namespace voltlap::plant {

class Amk {
 public:
  struct Setpoints {
    bool inverter_on = false, dc_on = false, enable = false, error_reset = false;
    double speed_rpm = 0.0, torque_positive_nm = 0.0, torque_negative_nm = 0.0;

    [[nodiscard]] bool zero() const {
      return speed_rpm == 0.0 && torque_positive_nm == 0.0 && torque_negative_nm == 0.0;
    }
  };
  static constexpr std::uint16_t kSetpointsLost = 1, kPlanted = 2;
  static constexpr double kDcOnTime_s = 0.1, kInverterOnTime_s = 0.05;  // assumed: the real ones take no longer
  static constexpr double kGain_nm_per_rpm = 0.02;                      // assumed

  explicit Amk(const InverterSection& inverter) : inverter_(inverter) {}

  void receive(const Setpoints& setpoints) {
    setpoints_ = setpoints;
    silence_s_ = 0.0;
    heard_ = true;
    if (setpoints.error_reset && setpoints.zero()) error_ = 0;
    if (!setpoints.dc_on || error_ != 0) switch_off();
    if (!setpoints.enable || !setpoints.inverter_on) stop();
    zero_seen_ = dc_on() && setpoints.enable && setpoints.inverter_on && (zero_seen_ || setpoints.zero());
  }

  /// Once a control period, with the voltage of the DC link.
  void advance(double elapsed_s, double dc_voltage_v) {
    silence_s_ += elapsed_s;
    if (heard_ && silence_s_ > inverter_.amk_timeout_s) fail(kSetpointsLost);
    if (!ready() || dc_voltage_v < inverter_.dc_voltage_min_v) switch_off();
    if (!ready() || !setpoints_.dc_on || dc_voltage_v < inverter_.dc_voltage_min_v) return;
    dc_on_s_ += elapsed_s;
    if (dc_on() && zero_seen_) inverter_on_s_ += elapsed_s;
  }

  /// Planted faults. One that is not ready obeys nothing and says so.
  void fail(std::uint16_t number) {
    error_ = number;
    switch_off();
  }
  void set_ready(bool ready) { able_ = ready; }

  [[nodiscard]] double nominal_torque_nm() const { return inverter_.amk_nominal_torque_nm; }
  [[nodiscard]] bool ready() const { return able_ && error_ == 0; }
  [[nodiscard]] std::uint16_t error() const { return error_; }
  [[nodiscard]] bool dc_on() const { return dc_on_s_ > kDcOnTime_s; }
  [[nodiscard]] bool inverter_on() const { return inverter_on_s_ > kInverterOnTime_s; }
  /// Torque [Nm] at a speed; none before the sequence has ended.
  [[nodiscard]] double torque_nm(double speed_rpm) const {
    if (!inverter_on()) return 0.0;
    const double wanted = kGain_nm_per_rpm * (setpoints_.speed_rpm - speed_rpm);
    return std::clamp(wanted, std::min(0.0, setpoints_.torque_negative_nm),
                      std::max(0.0, setpoints_.torque_positive_nm));
  }

 private:
  void stop() {
    zero_seen_ = false;
    inverter_on_s_ = 0.0;
  }
  void switch_off() {
    stop();
    dc_on_s_ = 0.0;
  }

  InverterSection inverter_;
  Setpoints setpoints_{};
  double silence_s_ = 0.0, dc_on_s_ = 0.0, inverter_on_s_ = 0.0;
  std::uint16_t error_ = 0;
  bool heard_ = false, able_ = true, zero_seen_ = false;
};

}  // namespace voltlap::plant
