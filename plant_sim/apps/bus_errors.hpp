// SPDX-License-Identifier: Apache-2.0
// The bus has errors of its own: an interface that is not there is an input, one that goes down fails the run.
#pragma once
#include <cstdio>

#include "apps/exit_code.hpp"
#include "core/errors.hpp"
#include "port/host/bus_error.hpp"

namespace voltlap::plant {

/// What `run` returns, or the exit code of a bus that went down.
template <class Run>
int with_bus_errors(const Run& run) {
  try {
    return run();
  } catch (const port::BusSetupError& error) {
    throw InputError(error.what());
  } catch (const port::BusDownError& error) {
    std::fprintf(stderr, "voltlap: %s\n", error.what());
    return kExitFailedRun;
  }
}

}  // namespace voltlap::plant
