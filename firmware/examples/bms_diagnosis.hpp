// SPDX-License-Identifier: Apache-2.0
// A tester's questions to the BMS of a board, answered behind its own frames; and the restart that one may ask for.
#pragma once
#include "app/bms_node.hpp"
#include "app/uds_server.hpp"
#include "base/diagnostic_address.hpp"
#include "port/image_info.hpp"
#include "port/restart.hpp"

namespace voltlap::examples {

class BmsDiagnosis {
 public:
  /// `restart` nullptr: the board cannot; a tester is refused.
  explicit BmsDiagnosis(port::Restart* restart)
      : restart_(restart), server_(kBmsAddress, {port::kImageInfo.version, port::kImageInfo.name, app::kBmsFaults}) {}

  /// No contactor is closed or about to be.
  [[nodiscard]] static bool rests(const app::BmsNode& node) {
    const bms::Output& out = node.output();
    const bool open = out.state == can::BmsState::kIdle || out.state == can::BmsState::kFault ||
                      out.state == can::BmsState::kInvalid || out.state == can::BmsState::kOpen;
    return open && !bms::commanded(out.contactors);
  }
  /// After the node's tick. Adds at most two frames; returns only where the board has not been restarted.
  void tick(Instant now, FrameView rx, const app::BmsNode& node, TxQueue& tx) {
    const bool may = restart_ != nullptr && rests(node);
    server_.tick(now, rx, {node.output().faults, node.state().faults.latched, may}, tx);
    const app::UdsRestart asked = server_.restart();
    if (asked != app::UdsRestart::kNone) restart_->restart(asked == app::UdsRestart::kBootLoader);
  }

 private:
  port::Restart* restart_;
  app::UdsServer server_;
};

}  // namespace voltlap::examples
