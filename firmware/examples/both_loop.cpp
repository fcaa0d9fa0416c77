// SPDX-License-Identifier: Apache-2.0
#include "examples/both_loop.hpp"

#include "examples/self_test.hpp"

namespace voltlap::examples {
namespace {

void append(const TxQueue& frames, Frame* to) {
  for (const Frame& frame : frames) *to++ = frame;
}

}  // namespace

void BothNodes::run() {
  memory_.restore(bms_);
  static_cast<void>(board_.watchdog.start(kWatchdogTime));
  for (Instant at = board_.clock.now();; at = at + kTick) {
    board_.clock.sleep_until(at);
    step();
    if (running_.bms) memory_.keep(bms_);
    board_.watchdog.feed();
  }
}

void BothNodes::step() {
  const Instant now = board_.clock.now();
  Frame* const off_bus = frames_ + master_tx_.size();
  append(master_tx_, frames_);
  std::size_t count = board_.can.receive(off_bus, kInbox);
  count += cells_.take(now, off_bus + count);

  if (clock_is_lost(board_.second_clock)) {
    bms_.refuse(can::WaitsFor::kSelfTestClock);
    master_.refuse();
  }
  if (running_.bms) step_bms(now, {frames_, master_tx_.size() + count}, {off_bus, count});
  append(bms_tx_, off_bus + count);
  if (running_.master) step_master(now, {off_bus, count + bms_tx_.size()}, {off_bus, count});
}

void BothNodes::step_bms(Instant now, FrameView rx, FrameView off_bus) {
  bms_tx_.clear();
  bms_.tick(now, rx, bms_tx_);
  cells_.bleed(bms_.output());
  diagnosis_.tick(now, off_bus, bms_, bms_tx_);
  static_cast<void>(board_.can.send(bms_tx_));  // frames that are lost grow old at their receivers
}

void BothNodes::step_master(Instant now, FrameView rx, FrameView off_bus) {
  master_tx_.clear();
  master_.tick(now, rx, master_tx_);
  master_diagnosis_.tick(now, off_bus, master_, BmsDiagnosis::rests(bms_), master_tx_);
  static_cast<void>(board_.can.send(master_tx_));
}

}  // namespace voltlap::examples
