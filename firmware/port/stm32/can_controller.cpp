// SPDX-License-Identifier: Apache-2.0
#include "port/stm32/can_controller.hpp"

namespace voltlap::port::stm32 {

std::size_t CanController::receive(Frame* frames, std::size_t capacity) {
  new_step_ = true;
  std::size_t count = 0;
  while (count < capacity && inbox_.pop(frames[count])) ++count;
  return count;
}

void CanController::take(const Frame& frame) {
  ++counts_.received;
  if (!inbox_.push(frame)) ++counts_.inbox_full;
}

bool CanController::next(Frame& frame) { return outbox_.pop(frame); }

/// True when nothing had to be dropped.
bool CanController::drop_old() {
  std::uint32_t dropped = abort_waiting();
  for (Frame frame; outbox_.pop(frame);) ++dropped;
  counts_.dropped += dropped;
  return dropped == 0;
}

bool CanController::send(const TxQueue& frames) {
  if (!ready_) return frames.size() == 0;
  let_sending_interrupt(false);
  bool all = true;
  if (new_step_) {
    leave_bus_off();
    all = drop_old();
  }
  new_step_ = false;
  for (const Frame& frame : frames) {
    if (!off_ && outbox_.push(frame)) continue;
    ++counts_.dropped;
    all = false;
  }
  fill();  // off the bus there is nothing to fill in
  let_sending_interrupt(true);
  return all;
}

}  // namespace voltlap::port::stm32
