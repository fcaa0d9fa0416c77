// SPDX-License-Identifier: Apache-2.0
// The logic in a Cascadia PM100 between its CAN commands and its current controller: what it obeys, and when it locks.
// By the maker's CAN protocol; the lockout and the rolling counter are as docs/inverters.md says.
#pragma once
#include <algorithm>
#include <cstdint>

#include "core/parameters.hpp"

namespace voltlap::plant {

class Pm100 {
 public:
  struct Command {
    double torque_nm = 0.0, limit_nm = 0.0;
    bool forward = false, enable = false, speed_mode = false;
    unsigned counter = 0;
  };
  static constexpr std::uint16_t kCommandLost = 1U << 11;  ///< of the low word of the run faults

  Pm100(const InverterSection& inverter, double constant_nm_per_a)
      : timeout_s_(inverter.pm100_timeout_s), torque_max_nm_(inverter.current_max_a * constant_nm_per_a) {}

  /// True: it counts as heard. One whose counter does not follow only says where the count is now.
  bool receive(const Command& command) {
    const bool follows = !counted_ || command.counter == (counter_ + 1U) % 16U;
    counted_ = true;
    counter_ = command.counter;
    if (!follows) return false;
    silence_s_ = 0.0;
    heard_ = true;
    if (!command.enable) {
      run_low_ = static_cast<std::uint16_t>(run_low_ & ~kCommandLost);
      locked_ = faulty();
    } else if (!command.forward || command.speed_mode) {
      locked_ = true;  // never asked for in this car
    }
    enabled_ = command.enable && !locked_;
    // A limit of 0 stands for the one of the EEPROM.
    const double most = command.limit_nm > 0.0 ? std::min(command.limit_nm, torque_max_nm_) : torque_max_nm_;
    torque_nm_ = enabled_ ? std::clamp(command.torque_nm, -most, most) : 0.0;
    return true;
  }

  void advance(double elapsed_s) {
    silence_s_ += elapsed_s;
    if (heard_ && silence_s_ > timeout_s_) trip(run_low_, kCommandLost);
  }

  /// Planted faults: they stay until power-off.
  void fail_running(std::uint16_t bits) { trip(run_low_, bits); }
  void fail_self_test(std::uint16_t bits) { trip(post_low_, bits); }
  /// Its lockout comes by itself, as with a brown-out of the enable input.
  void lock() { stop(); }

  [[nodiscard]] bool enabled() const { return enabled_; }
  [[nodiscard]] bool locked() const { return locked_; }
  [[nodiscard]] double torque_nm() const { return torque_nm_; }
  [[nodiscard]] std::uint16_t run_low() const { return run_low_; }
  [[nodiscard]] std::uint16_t post_low() const { return post_low_; }

 private:
  [[nodiscard]] bool faulty() const { return run_low_ != 0 || post_low_ != 0; }
  void trip(std::uint16_t& word, std::uint16_t bits) {
    word = static_cast<std::uint16_t>(word | bits);
    stop();
  }
  void stop() {
    locked_ = true;
    enabled_ = false;
    torque_nm_ = 0.0;
  }

  double timeout_s_, torque_max_nm_;
  double silence_s_ = 0.0, torque_nm_ = 0.0;
  std::uint16_t run_low_ = 0, post_low_ = 0;
  unsigned counter_ = 0;
  bool counted_ = false, heard_ = false, locked_ = true, enabled_ = false;
};

}  // namespace voltlap::plant
