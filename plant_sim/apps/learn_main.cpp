// SPDX-License-Identifier: Apache-2.0
// The commands of `voltlap` that learn a cell from recordings, real ones or those of the virtual bench, or measure by
// them.
#include "apps/bench_test_command.hpp"
#include "apps/guarded_main.hpp"
#include "apps/identify_command.hpp"
#include "apps/limit_test_command.hpp"
#include "apps/program.hpp"
#include "apps/soc_test_command.hpp"
#include "apps/validate_command.hpp"

namespace {

using namespace voltlap::plant;

int run(int argc, char** argv) {
  return run_commands<BenchTestCommand, IdentifyCommand, LimitTestCommand, SocTestCommand, ValidateCommand>(argc, argv);
}

}  // namespace

int main(int argc, char** argv) { return guarded_main(run, argc, argv); }
