// SPDX-License-Identifier: Apache-2.0
// A master controller on a board of its own. master_config.hpp is yours.
#include "app/master_node.hpp"
#include "examples/master_diagnosis.hpp"
#include "examples/self_test.hpp"
#include "examples/tick.hpp"
#include "master_config.hpp"
#include "port/board.hpp"
#include "port/cortex_m/memory_test.hpp"

using namespace voltlap;

int main() {
  const bool memory_good = port::memory_is_good();
  const examples::SelfTest self_test(memory_good, port::image_residue());
  const port::Board board = port::start_board();
  static app::MasterNode node(master::kMasterConfig);
  self_test.judge(node);
  static examples::MasterDiagnosis diagnosis(board.restart);
  static Frame inbox[examples::kInbox];
  static TxQueue tx;

  static_cast<void>(board.watchdog.start(examples::kWatchdogTime));
  for (Instant at = board.clock.now();; at = at + examples::kTick) {
    board.clock.sleep_until(at);
    const std::size_t count = board.can.receive(inbox, examples::kInbox);
    tx.clear();
    if (examples::clock_is_lost(board.second_clock)) node.refuse();
    const Instant now = board.clock.now();
    node.tick(now, {inbox, count}, tx);
    diagnosis.tick(now, {inbox, count}, node, true, tx);
    static_cast<void>(board.can.send(tx));  // frames that are lost grow old at their receivers
    board.watchdog.feed();
  }
}
