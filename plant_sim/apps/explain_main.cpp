// SPDX-License-Identifier: Apache-2.0
// The commands of `voltlap` that explain what a simulation gets wrong about a log.
#include "apps/explain_command.hpp"
#include "apps/guarded_main.hpp"
#include "apps/list_causes_command.hpp"
#include "apps/program.hpp"

namespace {

using namespace voltlap::plant;

int run(int argc, char** argv) { return run_commands<ExplainCommand, ListCausesCommand>(argc, argv); }

}  // namespace

int main(int argc, char** argv) { return guarded_main(run, argc, argv); }
