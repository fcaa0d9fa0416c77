// SPDX-License-Identifier: Apache-2.0
// The commands of `voltlap` for recorded logs: through the firmware, onto a bus, and both at once.
#include "apps/bus_errors.hpp"
#include "apps/guarded_main.hpp"
#include "apps/play_command.hpp"
#include "apps/program.hpp"
#include "apps/replay_command.hpp"
#include "apps/shadow_command.hpp"

namespace {

using namespace voltlap::plant;

int run(int argc, char** argv) {
  return with_bus_errors([&] { return run_commands<ReplayCommand, PlayCommand, ShadowCommand>(argc, argv); });
}

}  // namespace

int main(int argc, char** argv) { return voltlap::plant::guarded_main(run, argc, argv); }
