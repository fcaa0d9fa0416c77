// SPDX-License-Identifier: Apache-2.0
// One folder for the parsed DBC files of all tests of a run: each content is read by cantools once, the user's own
// cache is left alone, and what an earlier build left behind is not used.
#pragma once
#include <cstdlib>

#include "plant_sim/core/scratch.hpp"

inline const Scratch kDbcCache;  // made before the tests begin

inline void use_dbc_cache_of_this_run() {
  ::setenv("XDG_CACHE_HOME", kDbcCache.file("").c_str(), 1);
}
