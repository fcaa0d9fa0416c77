// SPDX-License-Identifier: Apache-2.0
// A master controller on a board of its own. master_config.hpp is yours.
#include "app/master_node.hpp"
#include "examples/tick.hpp"
#include "master_config.hpp"
#include "port/board.hpp"

using namespace voltlap;

int main() {
  const port::Board board = port::start_board();
  static app::MasterNode node(master::kMasterConfig);
  static Frame inbox[examples::kInbox];
  static TxQueue tx;

  static_cast<void>(board.watchdog.start(examples::kWatchdogTime));
  for (Instant at = board.clock.now();; at = at + examples::kTick) {
    board.clock.sleep_until(at);
    const std::size_t count = board.can.receive(inbox, examples::kInbox);
    tx.clear();
    node.tick(board.clock.now(), {inbox, count}, tx);
    static_cast<void>(board.can.send(tx));  // frames that are lost grow old at their receivers
    board.watchdog.feed();
  }
}
