// SPDX-License-Identifier: Apache-2.0
// The BMS as a member of the bus: frames and time in, sealed frames out.
#pragma once
#include "base/can_frame.hpp"
#include "base/time.hpp"
#include "bms/config.hpp"
#include "bms/estimate/soc_record.hpp"
#include "bms/limits/energy_to_go.hpp"
#include "bms/state.hpp"
#include "codec/seal.hpp"

namespace voltlap::app {

class BmsNode {
 public:
  explicit BmsNode(const bms::Config& config) : config_(config) {}

  /// One step, every 10 ms. `tx` is added to, never cleared.
  void tick(Instant now, FrameView rx, TxQueue& tx);

  /// Before the first tick: what was latched when the supply was lost.
  void restore_trips(std::uint32_t latched) { state_.faults.latched = latched; }

  /// Before the first tick: what was known of the cells when the supply was lost.
  void restore_soc(const bms::SocRecord& record) {
    bms::restore(config_, record, state_.soc);
    bms::restore_way(record, state_.energy_to_go);
  }

  /// Before a tick, most often the first: the board's self-test failed. Until the next power-on the BMS closes nothing,
  /// allows no current, and says why: ContactorCommand.WaitsFor.
  void refuse(can::WaitsFor failed) { state_.self_test = failed; }

  [[nodiscard]] const bms::Config& config() const { return config_; }
  [[nodiscard]] const bms::State& state() const { return state_; }
  [[nodiscard]] const bms::Output& output() const { return output_; }  ///< of the last tick

 private:
  bms::Config config_;
  bms::State state_{};
  bms::Output output_{};
  codec::Sealer sealer_{};
};

}  // namespace voltlap::app
