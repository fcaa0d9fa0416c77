// SPDX-License-Identifier: Apache-2.0
// Coarse steps of the current are allowed for where they look like a cause.
#include "discrepancy/steps.hpp"

#include <CppUTest/TestHarness.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "discrepancy/causes/list.hpp"

using namespace voltlap::plant;
using Eigen::VectorXd;

/// A current of 0 and 10 A in turn, ten rows a second, behind 50 V; causes with a typical size each.
TEST_GROUP(Steps) {
  std::vector<Cause> causes{3};  // three of the catalogue, with a typical size of 0.5
  Design design;
  NoiseModel noise{{"voltage", {1e-3, 0.0, 10.0, 3.0}}};

  void setup() override {
    Recording& log = design.comparison.log;
    log.time_s = VectorXd::LinSpaced(101, 0.0, 10.0);
    VectorXd current(101);
    for (int k = 0; k < 101; ++k) current(k) = k % 2 == 0 ? 0.0 : 10.0;
    log.signals = {{"current", current}, {"pack_voltage", VectorXd::Constant(101, 50.0)}};
    design.comparison.channels = {{"voltage", Balance::kVoltage, "V", VectorXd()}};
    const char* names[] = {"current_offset", "auxiliary_load", "time_skew"};
    for (int k = 0; k < 3; ++k) {
      Cause& cause = causes[static_cast<std::size_t>(k)];
      const auto all = catalogue({});
      cause = *std::find_if(all.begin(), all.end(), [&](const Cause& c) { return std::string_view(c.name) == names[k]; });
      cause.parameters = {{"size", "1", -1.0, 1.0, 0.5}};
      design.forms.emplace_back(k == 2 ? 2 : 1);
      for (std::size_t form = 0; form < design.forms.back().size(); ++form) {
        Column column;
        column.cause = k;
        column.form = form;
        column.repeats = 0.0;
        design.columns.push_back(column);
      }
    }
    design.forms[2][0].channel = "current";
    design.forms[2][1].channel = "pack_voltage";
  }
};

TEST(Steps, LookLikeTheseThreeAlone) {
  for (const Cause& cause : catalogue({})) {
    const bool one = std::any_of(causes.begin(), causes.end(),
                                 [&](const Cause& k) { return std::string_view(k.name) == cause.name; });
    CHECK_EQUAL(one, static_cast<bool>(cause.seeming));
  }
}

TEST(Steps, NoneChangeNothing) {
  allow_for_steps(0.0, causes, design, noise);
  for (const Column& column : design.columns) DOUBLES_EQUAL(0.0, column.repeats, 0.0);
  DOUBLES_EQUAL(3.0, noise["voltage"].current_a, 0.0);
}

TEST(Steps, AreNoiseBesideThatOfTheSensor) {
  allow_for_steps(4.0, causes, design, noise);
  DOUBLES_EQUAL(5.0, noise["voltage"].current_a, 1e-12);
}

TEST(Steps, AreAllowedForWhereTheyLookLikeACause) {
  design.columns[0].repeats = 6.0;
  allow_for_steps(4.0, causes, design, noise);
  DOUBLES_EQUAL(10.0, design.columns[0].repeats, 1e-12);                        // 4 A of typically 0.5, beside 6
  DOUBLES_EQUAL(400.0, design.columns[1].repeats, 1e-9);                        // 200 W of typically 0.5
  DOUBLES_EQUAL(2.0 * 0.1 * 16.0 / 100.0, design.columns[2].repeats, 1e-12);    // of steps of 10 A, 0.1 s apart
  DOUBLES_EQUAL(0.0, design.columns[3].repeats, 0.0);                           // the voltage has no part in it
}
