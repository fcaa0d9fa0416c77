// SPDX-License-Identifier: Apache-2.0
// The command of `voltlap` that puts recorded logs through the firmware.
#include "apps/guarded_main.hpp"
#include "apps/program.hpp"
#include "apps/replay_command.hpp"

namespace {

int run(int argc, char** argv) { return voltlap::plant::run_commands<voltlap::plant::ReplayCommand>(argc, argv); }

}  // namespace

int main(int argc, char** argv) { return voltlap::plant::guarded_main(run, argc, argv); }
