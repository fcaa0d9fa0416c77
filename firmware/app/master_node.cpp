// SPDX-License-Identifier: Apache-2.0
#include "app/master_node.hpp"

#include "master/transmit.hpp"

namespace voltlap::app {

void MasterNode::tick(Instant now, FrameView rx, TxQueue& tx) {
  master::ingest(now, rx, receiver_);
  output_ = master::step(config_, receiver_.input, state_);
  // MST-062: code that may be damaged had better not speak to the inverter, not even to say zero: it was never enabled.
  commanded_ = commanded_ || !refused();
  if (commanded_) master::transmit_to_inverter(output_, receiver_.inverter, sealer_, tx);
  master::transmit_status(output_, sealer_, tx);
}

// DIA-003
bool MasterNode::rests() const {
  const bool off = output_.drive_state == can::DriveState::kLvOn || output_.drive_state == can::DriveState::kFault;
  const Sample<can::BmsState>& bms = receiver_.input.bms_state;
  const bool open = !bms.good() || bms.value == can::BmsState::kIdle || bms.value == can::BmsState::kFault ||
                    bms.value == can::BmsState::kOpen;
  return off && open;
}

}  // namespace voltlap::app
