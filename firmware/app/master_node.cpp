// SPDX-License-Identifier: Apache-2.0
#include "app/master_node.hpp"

#include "master/transmit.hpp"

namespace voltlap::app {

void MasterNode::tick(Instant now, FrameView rx, TxQueue& tx) {
  master::ingest(now, rx, receiver_);
  output_ = master::step(config_, receiver_.input, state_);
  master::transmit(output_, sealer_, tx);
}

}  // namespace voltlap::app
