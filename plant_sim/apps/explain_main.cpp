// SPDX-License-Identifier: Apache-2.0
// The commands of `voltlap` that explain what a simulation gets wrong about a log.
#include "apps/explain_command.hpp"
#include "apps/guarded_main.hpp"
#include "apps/list_causes_command.hpp"
#include "apps/program.hpp"

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace {

using namespace voltlap::plant;

/// Columns of a whole log come and go by the hundred: their memory stays with the program, which would else spend
/// an eighth of its time on getting it from the system, cleared, again.
void keep_memory() {
#ifdef __GLIBC__
  constexpr int kMost = 1 << 30;  // bytes
  mallopt(M_MMAP_THRESHOLD, kMost);
  mallopt(M_TRIM_THRESHOLD, kMost);
#endif
}

int run(int argc, char** argv) {
  keep_memory();
  return run_commands<ExplainCommand, ListCausesCommand>(argc, argv);
}

}  // namespace

int main(int argc, char** argv) {
  return guarded_main(run, argc, argv);
}
