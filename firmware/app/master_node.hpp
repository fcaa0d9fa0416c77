// SPDX-License-Identifier: Apache-2.0
// The master controller as a member of the bus: frames and time in, sealed frames out.
#pragma once
#include "base/can_frame.hpp"
#include "base/time.hpp"
#include "codec/seal.hpp"
#include "master/config.hpp"
#include "master/ingest.hpp"
#include "master/master_step.hpp"

namespace voltlap::app {

class MasterNode {
 public:
  explicit MasterNode(const master::Config& config) : config_(config) {
    receiver_.inverter = master::inverter_link(config);
  }

  /// One step, every 10 ms. `tx` is added to, never cleared.
  void tick(Instant now, FrameView rx, TxQueue& tx);

  /// Before a tick, most often the first: the board's self-test failed. Until the next power-on there is no torque and
  /// no request for the tractive system, and MasterStatus.Faults says ConfigInvalid. Before the first tick: the
  /// inverter hears nothing of this node; later, that it shall stop.
  void refuse() { state_.drive.refused = true; }
  /// No torque, no wish for the tractive system, and no contactor that the BMS holds closed or is about to close: as it
  /// says, where it is heard.
  [[nodiscard]] bool rests() const;
  [[nodiscard]] bool refused() const { return state_.drive.refused; }

  [[nodiscard]] const master::State& state() const { return state_; }
  [[nodiscard]] const master::Output& output() const { return output_; }  ///< of the last tick

 private:
  master::Config config_;
  master::Receiver receiver_{};
  master::State state_{};
  master::Output output_{};
  codec::Sealer sealer_{};
  bool commanded_ = false;  ///< the inverter has been spoken to
};

}  // namespace voltlap::app
