// SPDX-License-Identifier: Apache-2.0
#include "learn/bench/plan_file.hpp"

#include "bench_fixtures.hpp"
#include "fixtures.hpp"
#include "learn/bench/plan_rows.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

std::string refusal(const std::string& plan, const std::vector<std::string>& settings = {}) {
  return input_error([&] { (void)shipped_plan(plan, settings); });
}

std::string refusal_of_text(const std::string& text) {
  const TemporaryFile file("plan.toml", text);
  return refusal(file.path());
}

void check(const std::string& message, std::initializer_list<const char*> parts) {
  for (const char* part : parts) STRCMP_CONTAINS(part, message.c_str());
}

}  // namespace

TEST_GROUP(PlanFile){};

TEST(PlanFile, ShippedPlansAreWhole) {
  for (const std::string& name : DataFolder(VOLTLAP_SOURCE_DIR "/plant_sim/data").names("bench")) {
    const BenchPlan plan = shipped_plan(name);
    STRCMP_EQUAL(name.c_str(), plan.name.c_str());
    CHECK(!plan.description.empty());
  }
}

TEST(PlanFile, APlanTakesFromItsBaseWhatItsKindHas) {
  const BenchPlan plan = shipped_plan("random_resistors_free");
  STRCMP_EQUAL("random", plan.kind.c_str());
  STRCMP_EQUAL("free", plan.box.mode.c_str());
  DOUBLES_EQUAL(150.0, plan.rest.seconds, 0.0);
  DOUBLES_EQUAL(0.0015, plan.instruments.sensors.cell_step_v, 0.0);
  LONGS_EQUAL(0, plan.schedule.soc.size());
}

TEST(PlanFile, SettingsOutrankTheFileAndASingleNumberIsAListOfOne) {
  const BenchPlan plan = shipped_plan("pulse_15", {"test.current_a=300", "box.mode=bath"});
  LONGS_EQUAL(1, plan.test.current_a.size());
  DOUBLES_EQUAL(300.0, plan.test.current_a[0], 0.0);
  STRCMP_EQUAL("bath", plan.box.mode.c_str());
}

TEST(PlanFile, UnknownPlanListsThoseThereAre) {
  check(refusal("pulse_16"), {"plan", "expected a bench plan (", "random_resistors", "Did you mean pulse_15?"});
}

TEST(PlanFile, UnknownKeyNamesTheNearestWithFileAndLine) {
  check(refusal_of_text("base = \"pulse_15\"\n[rest]\nrise_v_per_minute = 0.001\n"),
        {"plan.toml:3", "rest.rise_v_per_minute", "The nearest one is \"rest.rise_v_per_min\""});
  check(refusal("pulse_15", {"box.mod=bath"}), {"--set box.mod", "box.mode"});
}

TEST(PlanFile, WrongTypeAndRangeSayWhatIsExpected) {
  check(refusal("pulse_15", {"rest.window_s=long"}),
        {"--set rest.window_s", "long", "a number in s from 2 to 3600"});
  check(refusal("pulse_15", {"cells.count=0"}), {"found 0", "a whole number from 1 to 144"});
  check(refusal("pulse_15", {"instruments.noise=1"}), {"found 1", "true or false"});
  check(refusal("pulse_15", {"box.mode=oven"}), {"oven", "one of bath|controlled|free"});
  check(refusal("pulse_15", {"test.temperature_c=[22, 300]"}),
        {"found 300", "list of numbers in degC from -40 to 80"});
  check(refusal("pulse_15", {"test.temperature_c=[]"}), {"found []"});
}

TEST(PlanFile, MissingKeyIsNamedWithItsMeaning) {
  check(refusal_of_text("kind = \"pulse\"\n"), {"plan.toml", "no test.temperature_c", "base = \"pulse_15\""});
}

TEST(PlanFile, PlanWithoutAKindOrOfAnUnknownOneIsRefused) {
  check(refusal_of_text("[test]\ntemperature_c = 22\n"), {"no kind", "\"pulse\", \"random\" or \"hppc\""});
  check(refusal_of_text("kind = \"drive\"\n"), {"kind = \"drive\""});
}

TEST(PlanFile, KeyOfAnotherKindIsRefused) {
  check(refusal("random_resistors", {"test.current_a=100"}), {"test.current_a", "kind \"random\"", "pulse hppc"});
}

TEST(PlanFile, BadTomlAndACircleOfBasesAreRefused) {
  check(refusal_of_text("kind = pulse\n"), {"plan.toml:1", "no valid TOML"});
  const TemporaryFile file("circle.toml", "");
  const TemporaryFile self("circle.toml", "base = \"" + file.path() + "\"\nkind = \"pulse\"\n");
  check(refusal(self.path()), {"plans built on each other", "Remove one"});
}

TEST(PlanFile, CurrentBeyondTheBanksNamesTheNearest) {
  check(refusal("pulse_15", {"test.current_a=900"}), {"900 A", "nearest: 507 A with 10 of the high bank"});
}

TEST(PlanFile, ValuesThatDoNotFitToEachOtherAreRefused) {
  check(refusal("pulse_15", {"test.capacity_ah=[55, 54, 50]"}),
        {"3 values", "2, one for each of test.capacity_at_a"});
  check(refusal("pulse_15", {"test.capacity_at_a=[400, 35]"}), {"currents out of order"});
  check(refusal("pulse_15", {"schedule.soc=[0.2, 0.8]"}), {"schedule.soc", "each less than the one before"});
  check(refusal("pulse_15", {"schedule.step=[0.05, 0.1]"}), {"schedule.step", "3, one for each stretch"});
  check(refusal("pulse_15", {"rest.rule=fixed"}), {"rest.seconds", "more than 0"});
  check(refusal("pulse_15", {"rest.max_s=100"}), {"rest.max_s", "more than rest.window_s"});
  check(refusal("pulse_15", {"sampling.log_hz=3"}), {"sampling.log_hz", "8 Hz (sampling.rate_hz) or an even part"});
  check(refusal("pulse_15", {"cells.capacity_scale=[1, 1]"}),
        {"cells.capacity_scale", "4, one for each of cells.count"});
  check(refusal("pulse_15", {"test.temperature_c=70"}), {"70 degC", "between the air's 12 and 60 degC"});
  check(refusal("hppc", {"load.kind=resistor"}), {"load.kind", "cannot charge"});
  check(refusal("random_resistors", {"load.kind=cycler"}), {"load.kind", "\"resistor\""});
  check(refusal("random_resistors", {"load.resistors_max=11"}), {"at most 10"});
  check(refusal("random_resistors", {"load.resistors=[1, 2.5]"}), {"found 2.5", "whole numbers from 1 to 10"});
}

TEST(PlanFile, EveryKeyHasAMeaningAndAKind) {
  for (const PlanRow& row : plan_rows()) {
    CHECK(!row.meaning.empty() && !row.kinds.empty());
    CHECK(row.low <= row.high);
    POINTERS_EQUAL(&row, find_plan_row(row.key));
  }
}
