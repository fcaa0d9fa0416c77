// SPDX-License-Identifier: Apache-2.0
// BMS-023, BMS-030, BMS-031, MST-010, MST-012, MST-040 in every state that both nodes can reach together.
#include "firmware/app/state_space.hpp"

#include <cstdio>
#include <cstdlib>
#include <string>

#include "CppUTest/TestHarness.h"

using namespace voltlap::app::test;

TEST_GROUP(StateSpace){};

TEST(StateSpace, NoRuleIsBrokenAndNothingIsADeadEnd) {
  const char* given = std::getenv("VOLTLAP_STATE_SPACE_DEPTH");
  const std::size_t depth = given == nullptr ? 6 : std::stoul(given);
  const StateSpace space = explore(depth);
  std::printf("%zu states, %zu steps of them tried, at most %zu deeds from power-on%s\n", space.places.size(),
              space.steps, space.depth, space.whole ? ", all there are" : "");
  CHECK_TEXT(space.broken.empty(), space.broken.c_str());
  if (!space.whole) return;
  const auto dead = space.dead_ends();
  const std::string what = dead.empty() ? "" : space.way_to(dead.front());
  CHECK_TEXT(dead.empty(), what.c_str());
}
