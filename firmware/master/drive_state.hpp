// SPDX-License-Identifier: Apache-2.0
// EV.9: low voltage on -> tractive system requested -> active -> ready to drive. Any doubt leads back to low voltage.
#pragma once
#include "base/time.hpp"
#include "master/config.hpp"
#include "master/io.hpp"
#include "master/pedals.hpp"

namespace voltlap::master {

/// A push button that counts only after it has been seen released: a stuck one does nothing.
class Button {
 public:
  /// Call once a step; `known` is false when the input was not received.
  void update(bool known, bool down) {
    rising_ = known && down && armed_ && !held_;
    held_ = known && down && armed_;
    armed_ = known && (!down || armed_);
  }
  [[nodiscard]] bool rising() const { return rising_; }  ///< pressed in this step
  [[nodiscard]] bool held() const { return held_; }      ///< pressed, after having been released

 private:
  bool armed_ = false;
  bool held_ = false;
  bool rising_ = false;
};

struct DriveStateState {
  Button ts_on, rtd, reset;
  bool inverter_disobeys = false;  ///< written by master_step, from inverter_watch
  bool inverter_dropped = false;   ///< written by master_step: MST-065, MST-070
  bool inverters_wait = false;     ///< written by master_step: MST-068, not ready yet
  bool refused = false;            ///< written by the node's owner: the board's self-test failed
  // Computed by drive_state_step.
  DriveState mode = DriveState::kInvalid;
  Instant entered{};           ///< when `mode` began
  bool config_good = false;    ///< of the check at the first step
  bool ts_request = false;
  bool reset_request = false;
  bool rtd_waits = false;      ///< pressed while the inverters were not ready, and held since
  bool rtd_sound = false;
  Faults faults{};
};

void drive_state_step(const Config& config, const Input& input, const PedalState& pedals, DriveStateState& state);

}  // namespace voltlap::master
