// SPDX-License-Identifier: Apache-2.0
#include "explain/fit/refine.hpp"

#include <CppUTest/TestHarness.h>

#include <vector>

#include "wave_family.hpp"

namespace voltlap::explain {
namespace {

constexpr double kTrue = 3.0, kElse = 1.0;  // size of the cause, and of what no size of it takes

/// A cause whose effect turns from one wave into another as it grows: v wave + bend ((v - true)^2 - true^2) late_wave,
/// in a log that has `kElse` of the late wave less than it could take. Undamped steps go to the other side of the
/// truth, 2 bend kElse times as far.
struct Bending {
  double bend;
  unsigned seed;

  [[nodiscard]] double late(double v) const { return bend * ((v - kTrue) * (v - kTrue) - kTrue * kTrue); }
  [[nodiscard]] Family at(double v) const {
    SimulatedChannel made(seed);
    made.add_white(0.05);
    made.add((kTrue - v) * made.wave() + (late(kTrue) - kElse - late(v)) * made.late_wave());
    made.be_wave(made.wave() + 2.0 * bend * (v - kTrue) * made.late_wave());
    return family_of(made, "voltage");
  }
};

Set followed(const Bending& bending) {
  plant::Cause cause{};
  cause.name = "wave";
  cause.parameters = {{"size", "1", -20.0, 20.0, 1.0}};
  const std::vector<plant::Cause> causes{cause};
  const Family family = bending.at(0.0);
  Search search(family, causes);
  return refined(causes, family, search.nothing(), search.of({0}),
                 [&](const SetValues& at) { return bending.at(at.values[0][0]); });
}

}  // namespace

TEST_GROUP(Refine){};

TEST(Refine, StepsThatThrowEachOtherToAndFroEndWhereTheCauseIs) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    for (const double bend : {0.1, 0.3, 0.55, 0.7}) {
      const Set set = followed({bend, seed});
      CHECK(set.lead.decisive);
      DOUBLES_EQUAL(kTrue, set.values[0][0], 0.1);
    }
  }
}

}  // namespace voltlap::explain
