// SPDX-License-Identifier: Apache-2.0
// BMS and master controller on one board. pack_config.hpp and master_config.hpp are yours.
#include "examples/both_loop.hpp"
#include "examples/self_test.hpp"
#include "master_config.hpp"
#include "pack_config.hpp"
#include "port/cortex_m/memory_test.hpp"

using namespace voltlap;

int main() {
  const bool memory_good = port::memory_is_good();
  const examples::SelfTest self_test(memory_good, port::image_residue());
  const port::Board board = port::start_board();
  static app::BmsNode bms(bms::kPackConfig);
  static app::MasterNode master(master::kMasterConfig);
  self_test.judge(bms);
  self_test.judge(master);
  static examples::BothNodes nodes(board, bms, master);
  nodes.run();
}
