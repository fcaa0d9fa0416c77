// SPDX-License-Identifier: Apache-2.0
// A tester's questions to the master controller of a board, as those to the BMS: examples/bms_diagnosis.hpp.
#pragma once
#include "app/master_node.hpp"
#include "app/uds_server.hpp"
#include "base/diagnostic_address.hpp"
#include "port/image_info.hpp"
#include "port/restart.hpp"

namespace voltlap::examples {

class MasterDiagnosis {
 public:
  /// `restart` nullptr: the board cannot; a tester is refused.
  explicit MasterDiagnosis(port::Restart* restart)
      : restart_(restart),
        server_(kMasterAddress, {port::kImageInfo.version, port::kImageInfo.name, app::kMasterFaults}) {}

  /// After the node's tick. `board_rests`: what else runs on this board may be started anew, too.
  void tick(Instant now, FrameView rx, const app::MasterNode& node, bool board_rests, TxQueue& tx) {
    const bool may = restart_ != nullptr && board_rests && node.rests();
    server_.tick(now, rx, {node.output().faults.bits, node.state().pedals.latched.bits, may}, tx);
    const app::UdsRestart asked = server_.restart();
    if (asked != app::UdsRestart::kNone) restart_->restart(asked == app::UdsRestart::kBootLoader);
  }

 private:
  port::Restart* restart_;
  app::UdsServer server_;
};

}  // namespace voltlap::examples
