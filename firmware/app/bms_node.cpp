// SPDX-License-Identifier: Apache-2.0
#include "app/bms_node.hpp"

#include "bms/bms_step.hpp"
#include "bms/transmit.hpp"

namespace voltlap::app {

void BmsNode::tick(Instant now, FrameView rx, TxQueue& tx) {
  output_ = bms::step(config_, bms::Input{now, rx}, state_);
  bms::transmit(output_, sealer_, tx);
}

}  // namespace voltlap::app
