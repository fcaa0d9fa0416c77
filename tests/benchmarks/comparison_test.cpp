// SPDX-License-Identifier: Apache-2.0
#include "comparison.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::benchmarks;

namespace {

Row row(const char* name, double relative, double uncertain = 0.02) {
  Row out{.name = name, .operation = "something", .repetitions = 20, .sim_s_per_s = 1.0};
  out.estimate = {.ns = 1000.0 * relative, .relative = relative, .low = relative, .high = relative * (1.0 + uncertain)};
  return out;
}

Measurement with(std::vector<Row> rows) { return {.machine = {}, .reference_ns = 1000.0, .rows = std::move(rows)}; }

Verdict verdict(const Row& earlier, const Row& now) { return compare(with({earlier}), with({now})).front().verdict; }

}  // namespace

TEST_GROUP(Comparison){};

TEST(Comparison, TwofoldSlowdownIsFoundAlsoInNoise) {
  CHECK(Verdict::kSlower == verdict(row("lap", 1.0), row("lap", 2.0)));
  CHECK(Verdict::kSlower == verdict(row("lap", 1.0, 0.5), row("lap", 2.0, 0.5)));
}

TEST(Comparison, ChangeAroundTheThresholdIsTakenForRealOnlyBeyondIt) {
  CHECK(Verdict::kAsBefore == verdict(row("lap", 1.0, 0.0), row("lap", kThreshold - 0.001, 0.0)));
  CHECK(Verdict::kSlower == verdict(row("lap", 1.0, 0.0), row("lap", kThreshold + 0.001, 0.0)));
  CHECK(Verdict::kAsBefore == verdict(row("lap", 1.0, 0.0), row("lap", 1.0 / (kThreshold - 0.001), 0.0)));
  CHECK(Verdict::kFaster == verdict(row("lap", 1.0, 0.0), row("lap", 1.0 / (kThreshold + 0.001), 0.0)));
}

TEST(Comparison, WideIntervalIsNoEvidence) {
  CHECK(Verdict::kAsBefore == verdict(row("lap", 1.0, 0.2), row("lap", 1.3)));
  CHECK(Verdict::kSlower == verdict(row("lap", 1.0, 0.02), row("lap", 1.3)));
}

TEST(Comparison, LowerBoundThatReachesDownIsNoEvidence) {
  Row now = row("lap", 1.5);
  now.estimate.low = 1.1;
  CHECK(Verdict::kAsBefore == verdict(row("lap", 1.0), now));
}

TEST(Comparison, MachineThatIsTwiceAsSlowIsNoSlowdown) {
  Row now = row("lap", 1.0);
  now.estimate.ns *= 2.0;
  CHECK(Verdict::kAsBefore == verdict(row("lap", 1.0), now));
}

TEST(Comparison, OnlyARowThatIsSlowerFailsIt) {
  CHECK(any_slower(compare(with({row("a", 1.0), row("b", 1.0)}), with({row("a", 1.0), row("b", 2.0)}))));
  CHECK_FALSE(any_slower(compare(with({row("a", 1.0), row("b", 1.0)}), with({row("a", 0.4), row("c", 9.0)}))));
}

TEST(Comparison, RowsThatOnlyOneOfTheTwoHasAreShown) {
  const Measurement earlier = with({row("old", 1.0)}), now = with({row("fresh", 1.0)});
  const auto rows = compare(earlier, now);
  LONGS_EQUAL(2, rows.size());
  CHECK(rows[0].name == "fresh" && rows[0].verdict == Verdict::kNew);
  CHECK(rows[1].name == "old" && rows[1].verdict == Verdict::kNotMeasured);
  STRCMP_CONTAINS("not measured", comparison_text(earlier, now, rows).c_str());
}

TEST(Comparison, TableStatesTheThresholdAndWhatDiffersBetweenTheMachines) {
  Measurement earlier = with({row("lap", 1.0)}), now = with({row("lap", 2.0)});
  earlier.machine.cpu = "one";
  now.machine.cpu = "other";
  const std::string text = comparison_text(earlier, now, compare(earlier, now));
  STRCMP_CONTAINS("factor of 1.15", text.c_str());
  STRCMP_CONTAINS("cpu differs: one earlier, other now", text.c_str());
  STRCMP_CONTAINS("2.00   1.96 .. 2.04", text.c_str());
  STRCMP_CONTAINS("SLOWER", text.c_str());
}
