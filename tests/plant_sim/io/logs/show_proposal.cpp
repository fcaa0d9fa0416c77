// SPDX-License-Identifier: Apache-2.0
// show_proposal RECORDING [DBC...]: "complete" or "open", and the draft of a role map for it.
#include <fmt/format.h>

#include <cstdio>

#include "core/errors.hpp"
#include "io/logs/can/can_recording.hpp"
#include "io/logs/map_proposal.hpp"

int main(int argc, char** argv) {
  using namespace voltlap::plant;
  if (argc < 2) return 2;
  try {
    const std::string path = argv[1];
    const MapProposal proposal = is_can_recording(path) ? propose_map(signals_of(path, {argv + 2, argv + argc}))
                                                        : propose_map(signals_of(read_measured_table(path)));
    fmt::print("{}\n{}", proposal.is_complete() ? "complete" : "open", proposal.draft());
  } catch (const InputError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
  return 0;
}
