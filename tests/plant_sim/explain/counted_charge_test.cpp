// SPDX-License-Identifier: Apache-2.0
// A counter of the charge beside a current that is read ten times a second: what flowed between the rows is known,
// the counter's sign and its restarts do not matter, and one that says another thing than the current is not
// believed.
#include "explain/balances/counted_charge.hpp"

#include <CppUTest/TestHarness.h>

#include <cmath>
#include <random>

#include "explain/balances/balances.hpp"
#include "explain/balances/model.hpp"

using namespace voltlap::plant;
using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr Index kRows = 2000, kFine = 20;  // rows; times of 5 ms between two of them

/// Pulls that begin and end anywhere between two rows.
struct Pulls {
  Recording log;
  double drawn_ah = 0.0;
};
Pulls pulls(double counter_scale = 1.0) {
  Pulls out;
  std::mt19937 random(7);
  std::exponential_distribution<double> lasts(1.0);
  out.log.time_s = VectorXd::LinSpaced(kRows, 0.0, 0.1 * (kRows - 1));
  VectorXd &current = out.log.signals["current"], &charge = out.log.signals["charge_ah"];
  current = charge = VectorXd::Zero(kRows);
  double until_s = 3.0, amperes = 0.0;
  for (Index k = 0; k < (kRows - 1) * kFine; ++k) {
    const double time_s = 0.1 / kFine * static_cast<double>(k);
    if (time_s >= until_s) {
      amperes = amperes > 0.0 ? 0.0 : 180.0;
      until_s += lasts(random);
    }
    if (k % kFine == 0) current(k / kFine) = amperes;
    out.drawn_ah += amperes * 0.1 / kFine / 3600.0;
    if ((k + 1) % kFine == 0) charge((k + 1) / kFine) = counter_scale * out.drawn_ah;
  }
  current(kRows - 1) = amperes;
  out.log.signals["voltage"] = VectorXd::Constant(kRows, 3.9);
  return out;
}

World leaf() {
  return load_model(DataFolder(VOLTLAP_DATA_FOLDER), "aesc_e5_2p", {}).world;
}

double soc_drawn(const Recording& log) {
  const World model = leaf();
  const VectorXd soc = predict(model, comparison_of(model, log, {})).battery.soc;
  return soc(0) - soc(kRows - 1);
}

}  // namespace

TEST_GROUP(CountedCharge){};

TEST(CountedCharge, WhatFlowedBetweenTheRowsIsDrawn) {
  Pulls counted = pulls();
  const World model = leaf();
  const double true_soc = counted.drawn_ah / model.car.battery.cells_in_parallel / model.car.cell.capacity_ah;
  DOUBLES_EQUAL(true_soc, soc_drawn(counted.log), 1e-4 * true_soc);
  counted.log.signals.erase("charge_ah");
  CHECK(std::abs(soc_drawn(counted.log) - true_soc) > 1e-3 * true_soc);  // the rows alone do not tell it
}

TEST(CountedCharge, ACounterOfChargeCountsAsOneOfDischarge) {
  const VectorXd down = counted_current(pulls(1.0).log), up = counted_current(pulls(-1.0).log);
  LONGS_EQUAL(kRows, down.size());
  DOUBLES_EQUAL(0.0, (down - up).tail(kRows - 1).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(CountedCharge, ACounterThatContradictsTheCurrentIsNotBelieved) {
  LONGS_EQUAL(0, counted_current(pulls(0.5).log).size());
  LONGS_EQUAL(0, counted_current(pulls(2.0).log).size());
}

TEST(CountedCharge, ACoarseCounterIsNotBelieved) {
  Recording log = pulls().log;
  VectorXd& charge = log.signals["charge_ah"];
  charge = (0.02 * (charge.array() / 0.02).floor()).matrix();
  LONGS_EQUAL(0, counted_current(log).size());
}

TEST(CountedCharge, ARestartOfTheCounterSaysNothing) {
  Recording log = pulls().log;
  VectorXd& charge = log.signals["charge_ah"];
  const double before = charge(999);
  charge.tail(1000).array() -= before;
  const VectorXd mean = counted_current(log);
  LONGS_EQUAL(kRows, mean.size());
  CHECK(std::isnan(mean(1000)));
  CHECK(std::isfinite(mean(1001)));
}
