// SPDX-License-Identifier: Apache-2.0
// BMS and master controller on one board and one bus: a controller does not hear its own frames, so what one node sends
// is handed to the other here.
#pragma once
#include "app/bms_node.hpp"
#include "app/master_node.hpp"
#include "examples/bms_diagnosis.hpp"
#include "examples/bms_memory.hpp"
#include "examples/master_diagnosis.hpp"
#include "examples/own_cells.hpp"
#include "examples/tick.hpp"
#include "port/board.hpp"

namespace voltlap::examples {

class BothNodes {
 public:
  /// Of the two, those that run: on an emulated board a plant may want one alone.
  struct Running {
    bool bms = true, master = true;
  };

  BothNodes(const port::Board& board, app::BmsNode& bms, app::MasterNode& master, Running running = {true, true})
      : board_(board), bms_(bms), master_(master), running_(running), memory_(board.nvm),
        cells_(board.cells, bms.config()),
        diagnosis_(board.restart), master_diagnosis_(board.restart) {}

  [[noreturn]] void run();

 private:
  void step();
  /// Each sends once, and hears the frames on the bus and those that the other has sent since.
  void step_bms(Instant now, FrameView rx, FrameView off_bus);
  void step_master(Instant now, FrameView rx, FrameView off_bus);

  const port::Board board_;
  app::BmsNode& bms_;
  app::MasterNode& master_;
  const Running running_;
  BmsMemory memory_;
  OwnCells cells_;
  BmsDiagnosis diagnosis_;
  MasterDiagnosis master_diagnosis_;
  /// What the master sent in the tick before, the frames off the bus and of the board's own cells, what the BMS sends
  /// now: in this order, so that each node's frames lie together.
  Frame frames_[2 * TxQueue::kCapacity + kInbox + OwnCells::kFramesMax] = {};
  TxQueue bms_tx_, master_tx_;
};

}  // namespace voltlap::examples
