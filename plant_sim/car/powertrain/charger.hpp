// SPDX-License-Identifier: Apache-2.0
// A charger on the DC link: gives the current that it is told, within its own power, current and a voltage that it is
// told, and stops when the commands fall silent.
//
//   I = lag(min(I_command, I_max, P / V, I_v)),   dI_v/dt = (V_command - V) 10 I_max / V_command per second, 0 to I_max
// Time of silence: protocol of Elcon and TC Charger, 5 s.
#pragma once
#include <algorithm>
#include <cmath>

#include "core/parameters.hpp"

namespace voltlap::plant {

class Charger {
 public:
  static constexpr double kTimeout_s = 5.0;

  explicit Charger(const ChargerSection& section) : section_(section), by_voltage_a_(section.current_max_a) {}

  bool plugged = false;          ///< to the car; its side feeds the low-voltage system too
  bool failed = false;           ///< planted: a fault of its hardware, and no output
  bool ignores_commands = false; ///< planted: hears them and goes on as it is

  void command(double voltage_max_v, double current_max_a, bool on) {
    silence_s_ = 0.0;
    if (ignores_commands) return;
    voltage_max_v_ = voltage_max_v;
    command_a_ = current_max_a;
    on_ = on;
  }
  /// Time passes, with the DC link at `link_v`; `connected`: it sees a battery there.
  void advance(double elapsed_s, double link_v, bool connected) {
    silence_s_ += elapsed_s;
    connected_ = connected;
    link_v_ = link_v;
    const bool gives = on_ && plugged && connected && !failed && !silent();
    follow_voltage(elapsed_s);
    const double by_power = link_v > 1.0 ? section_.power_w / link_v : 0.0;
    const double most = std::min({command_a_, section_.current_max_a, by_power, by_voltage_a_});
    const double target = gives ? std::max(0.0, most) : 0.0;
    const double kept = section_.response_s > 0.0 ? std::exp(-elapsed_s / section_.response_s) : 0.0;
    current_a_ = connected ? target + (current_a_ - target) * kept : 0.0;
    if (target == 0.0 && current_a_ < kNothing_a) current_a_ = 0.0;
  }

  [[nodiscard]] double current_a() const { return current_a_; }
  [[nodiscard]] double link_v() const { return link_v_; }
  [[nodiscard]] bool silent() const { return silence_s_ >= kTimeout_s; }
  [[nodiscard]] bool connected() const { return connected_; }

 private:
  static constexpr double kNothing_a = 1e-3;

  void follow_voltage(double elapsed_s) {
    if (voltage_max_v_ <= 0.0) return;
    const double gain = 10.0 * section_.current_max_a / voltage_max_v_;
    by_voltage_a_ += (voltage_max_v_ - link_v_) * gain * elapsed_s;
    by_voltage_a_ = std::clamp(by_voltage_a_, 0.0, section_.current_max_a);
  }

  ChargerSection section_;
  double voltage_max_v_ = 0.0, command_a_ = 0.0, by_voltage_a_, current_a_ = 0.0, link_v_ = 0.0;
  double silence_s_ = kTimeout_s;
  bool on_ = false, connected_ = false;
};

}  // namespace voltlap::plant
