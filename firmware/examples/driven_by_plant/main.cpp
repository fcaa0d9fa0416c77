// SPDX-License-Identifier: Apache-2.0
// BMS and master controller for any car of the plant, which hands them their configurations when it starts them:
// what `--ecu qemu` and `--ecu process` of `voltlap endurance` and `voltlap faults` run. Only for boards in lockstep.
#include "examples/both_loop.hpp"
#include "examples/self_test.hpp"
#include "port/lockstep/lockstep_board.hpp"

using namespace voltlap;

int main() {
  const examples::SelfTest self_test(true, port::image_residue());
  const port::LockstepBoard lockstep = port::start_lockstep_board();
  static bms::Config bms_config;
  static master::Config master_config;
  lockstep.plant.greet(&bms_config, sizeof bms_config, &master_config, sizeof master_config, bms::kMaxTemperatures);
  static app::BmsNode bms(bms_config);
  static app::MasterNode master(master_config);
  self_test.judge(bms);
  self_test.judge(master);
  static examples::BothNodes nodes(lockstep.board, bms, master,
                                   {lockstep.plant.runs_bms(), lockstep.plant.runs_master()});
  nodes.run();
}
