// SPDX-License-Identifier: Apache-2.0
// A BMS on a board of its own. pack_config.hpp is yours: ./voltlap firmware-tables CELL --vehicle CAR --out FILE.
#include "app/bms_node.hpp"
#include "examples/bms_diagnosis.hpp"
#include "examples/bms_memory.hpp"
#include "examples/own_cells.hpp"
#include "examples/self_test.hpp"
#include "examples/tick.hpp"
#include "pack_config.hpp"
#include "port/board.hpp"
#include "port/cortex_m/memory_test.hpp"

using namespace voltlap;

namespace {

/// Relays that hang on this board follow the node; those of a board that has none hear it from the bus.
void drive_pins(const bms::Output& output, port::Gpio& gpio) {
  gpio.set(port::Drive::kAirPlus, output.contactors.air_plus);
  gpio.set(port::Drive::kAirMinus, output.contactors.air_minus);
  gpio.set(port::Drive::kPrecharge, output.contactors.precharge);
  gpio.set(port::Drive::kShutdownRelay, output.state != can::BmsState::kFault);
}

}  // namespace

int main() {
  const bool memory_good = port::memory_is_good();
  const examples::SelfTest self_test(memory_good, port::image_residue());
  const port::Board board = port::start_board();
  static app::BmsNode node(bms::kPackConfig);
  static examples::BmsMemory memory(board.nvm);
  static examples::OwnCells cells(board.cells, bms::kPackConfig);
  static examples::BmsDiagnosis diagnosis(board.restart);
  static Frame inbox[examples::kInbox + examples::OwnCells::kFramesMax];
  static TxQueue tx;

  memory.restore(node);
  self_test.judge(node);
  static_cast<void>(board.watchdog.start(examples::kWatchdogTime));
  for (Instant at = board.clock.now();; at = at + examples::kTick) {
    board.clock.sleep_until(at);
    const Instant now = board.clock.now();
    std::size_t count = board.can.receive(inbox, examples::kInbox);
    count += cells.take(now, inbox + count);
    tx.clear();
    if (examples::clock_is_lost(board.second_clock)) node.refuse(can::WaitsFor::kSelfTestClock);
    node.tick(now, {inbox, count}, tx);
    drive_pins(node.output(), board.gpio);
    cells.bleed(node.output());
    diagnosis.tick(now, {inbox, count}, node, tx);
    static_cast<void>(board.can.send(tx));  // frames that are lost grow old at their receivers
    memory.keep(node);
    board.watchdog.feed();
  }
}
