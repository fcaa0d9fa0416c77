// SPDX-License-Identifier: Apache-2.0
#include "replay/disagreements.hpp"

#include <algorithm>

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(Disagreements) {
  /// A hundred seconds of 20 A, 5.6 points of 10 Ah, in which the SOC moves by so much.
  static bool doubted(double moved) {
    ReplayResult result;
    result.capacity_ah = 10.0;
    for (int k = 0; k <= 200; ++k) {
      ReplayRow row;
      row.time_s = 0.5 * k;
      row.current_a = 20.0;
      row.soc = 0.5 + moved * k / 200.0;
      result.rows.push_back(row);
    }
    const std::vector<Disagreement> found = find_disagreements(result);
    return std::any_of(found.begin(), found.end(), [](const Disagreement& one) {
      return one.what.starts_with("the firmware's SOC rises by");
    });
  }
};

// A filter that is led by cells which its model does not describe leaves the charge that is counted.
TEST(Disagreements, ASocThatRisesWhileChargeIsDrawnIsNotBelieved) {
  CHECK(doubted(0.04));
  CHECK(!doubted(0.003));
  CHECK(!doubted(-0.02));
  CHECK(!doubted(-0.056));
}
