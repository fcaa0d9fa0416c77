// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/identify.hpp"
#include "learn/identify/result/law_facts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "known_cell.hpp"
#include "learn/identify/result/excitation.hpp"
#include "plant_sim/core/scratch.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(Identify) {
  KnownCell cell;
  IdentifyOptions options;
  void setup() override {
    options.branches = 2;
    options.hold = CurrentHold::kNext;  // as KnownCell records
  }
  /// SOC of the cell where the fit, with the capacity that it found, has this one.
  [[nodiscard]] double true_soc(const IdentifyResult& r, double soc) const {
    return 1.0 - (1.0 - soc) * r.model.capacity_ah / cell.capacity_ah;
  }
  std::vector<CellLog> logs_of(const std::vector<double>& plan) {
    return {cell.record(plan)};
  }
};

TEST(Identify, KnownCellIsRecoveredFromFourHoursOfPulses) {
  cell.noise_v = 5e-4;
  cell.step_v = 1e-3;
  const IdentifyResult r = identify(logs_of(cell.pulse_plan(33.0, 640, 0.0)), options);
  DOUBLES_EQUAL(cell.capacity_ah, r.model.capacity_ah, 0.05);
  STRCMP_EQUAL("evidence", r.smoothness_from.c_str());
  // Noise and a step of 1 mV: what a perfect model leaves.
  DOUBLES_EQUAL(std::sqrt(cell.noise_v * cell.noise_v + cell.step_v * cell.step_v / 12.0), r.rms_v, 1e-5);
  for (Eigen::Index node = 0; node < r.model.grid.size(); ++node) {
    const double s = r.model.grid.at(node), t = true_soc(r, s);
    DOUBLES_EQUAL(KnownCell::em(t), r.model.ocv.value(r.model.em, s), 2e-3);
    DOUBLES_EQUAL(1.0, r.model.r(node, 0) / KnownCell::r0(t), 0.01);
    DOUBLES_EQUAL(1.0, r.model.r(node, 1) / KnownCell::r1(t), 0.05);
    DOUBLES_EQUAL(1.0, r.model.r(node, 2) / KnownCell::r2(t), 0.05);
    DOUBLES_EQUAL(1.0, r.model.tau(node, 0) / KnownCell::tau1(t), 0.1);
    DOUBLES_EQUAL(1.0, r.model.tau(node, 1) / KnownCell::tau2(t), 0.1);
  }
}

TEST(Identify, APlainCircuitHasOneValueForAllSocThatPredictsAlmostAsWell) {
  const std::vector<CellLog> logs = logs_of(cell.pulse_plan(33.0, 320, 0.0));
  const IdentifyResult tables = identify(logs, options);
  options.constant = true;
  const IdentifyResult plain = identify(logs, options);
  for (Eigen::Index column = 0; column <= 2; ++column) {
    const auto values = plain.model.r.col(column);
    DOUBLES_EQUAL(1.0, values.maxCoeff() / values.minCoeff(), 1e-3);
    CHECK(tables.model.r.col(column).maxCoeff() / tables.model.r.col(column).minCoeff() > 1.1);
  }
  DOUBLES_EQUAL(1.0, plain.model.r.row(0).sum() / tables.model.r.rowwise().sum().mean(), 0.15);
  for (Eigen::Index column = 0; column < 2; ++column)
    DOUBLES_EQUAL(1.0, plain.model.tau.col(column).maxCoeff() / plain.model.tau.col(column).minCoeff(), 1e-3);
  CHECK(plain.rms_v > tables.rms_v && plain.rms_v < 0.03);
}

TEST(Identify, HowSmoothTheOcvOfAPlainCircuitIsPulsesDecideThatItDidNotSee) {
  options.constant = true;
  const IdentifyResult plain = identify(logs_of(cell.pulse_plan(33.0, 320, 0.0)), options);
  STRCMP_EQUAL("held-out pulses", plain.smoothness_from.c_str());
  const auto error_at = [&](double smoothness) {
    const auto found = std::find_if(plain.smoothness_scores.begin(), plain.smoothness_scores.end(),
                                    [&](const auto& score) { return score.first == smoothness; });
    CHECK(found != plain.smoothness_scores.end());
    return found->second;
  };
  for (const auto& [smoothness, error] : plain.smoothness_scores) {
    if (smoothness < plain.smoothness) CHECK(error > error_at(plain.smoothness));  // none as good is smoother
  }
  CHECK(plain.smoothness_scores.size() >= 3);
}

TEST(Identify, TheOcvOfAPlainCircuitIsNotChosenByAMinute) {
  options.constant = true;
  std::vector<double> drive;
  for (int k = 0; k < 4; ++k) drive.insert(drive.end(), 20, k % 2 == 0 ? 60.0 : 15.0);
  const IdentifyResult plain = identify(logs_of(drive), options);
  STRCMP_EQUAL("--constant", plain.smoothness_from.c_str());
}

TEST(Identify, ADriveOfUnknownTemperatureGetsNoSlopeOverItAndATestWithRestsDoes) {
  std::vector<double> drive(60, 0.0);
  for (int k = 0; k < 60; ++k) drive.insert(drive.end(), 20, k % 2 == 0 ? 60.0 : 15.0);
  options.temperature_told = false;
  const IdentifyResult warmed = identify(logs_of(drive), options);
  CHECK(!warmed.model.laws.has_temperature());
  CHECK(std::any_of(warmed.notes.begin(), warmed.notes.end(), [](const std::string& note) {
    return note.find("no rest lets the cell cool") != std::string::npos;
  }));
  DOUBLES_EQUAL(15.0, identify(logs_of(cell.pulse_plan(33.0, 640)), options).model.laws.ohmic_kj_per_mol, 1e-9);
  options.temperature_told = true;
  DOUBLES_EQUAL(15.0, identify(logs_of(drive), options).model.laws.ohmic_kj_per_mol, 1e-9);
}

TEST(Identify, ADischargeWithoutAThermometerWarmsByItsBody) {
  // 2.5C to empty, of a cell that keeps all of its heat: about 200 mV at 75 A for 24 minutes warm 500 J/K by 43 K.
  std::vector<double> plan(300, 0.0);
  plan.insert(plan.end(), 1400, 75.0);
  plan.insert(plan.end(), 900, 0.0);
  const auto logs = logs_of(plan);
  const IdentifyResult held = identify(logs, options);
  options.thermal = [](double) { return CellThermal{500.0, 0.01, 0.0}; };
  const IdentifyResult warmed = identify(logs, options);
  DOUBLES_EQUAL(held.files[0].coldest_c, held.files[0].warmest_c, 0.0);
  CHECK(warmed.files[0].warmest_c > 25.0 + 25.0 && warmed.files[0].warmest_c < 25.0 + 60.0);
  CHECK(std::any_of(warmed.notes.begin(), warmed.notes.end(), [](const std::string& note) {
    return note.find("no temperature was recorded; by the heat that it makes") != std::string::npos;
  }));
  // What a warm cell showed is more at the temperature of the tables.
  CHECK(warmed.model.r(3, 0) > 1.2 * held.model.r(3, 0));
  // A body that hardly warms is left as it is.
  options.thermal = [](double) { return CellThermal{1e6, 0.01, 0.0}; };
  DOUBLES_EQUAL(held.model.r(3, 0), identify(logs, options).model.r(3, 0), 1e-12);
}

TEST(Identify, IntervalsCoverNineTenthsOfTheTruth) {
  cell.noise_v = 5e-4;
  const IdentifyResult r = identify(logs_of(cell.pulse_plan(33.0, 640, 0.0)), options);
  int covered = 0, all = 0;
  const auto check = [&](Eigen::Index table, Eigen::Index node, double value, double truth) {
    if (!is_excited(r, table, node)) return;
    const double sigma = r.uncertainty.sigma(r.model.em.size() + table * r.model.grid.size() + node);
    covered += std::abs(std::log(value / truth)) < 1.96 * sigma ? 1 : 0;
    ++all;
  };
  for (Eigen::Index node = 0; node < r.model.grid.size(); ++node) {
    const double s = true_soc(r, r.model.grid.at(node));
    check(0, node, r.model.r(node, 0), KnownCell::r0(s));
    check(1, node, r.model.r(node, 1), KnownCell::r1(s));
    check(2, node, r.model.r(node, 2), KnownCell::r2(s));
    check(3, node, r.model.tau(node, 0), KnownCell::tau1(s));
    check(4, node, r.model.tau(node, 1), KnownCell::tau2(s));
  }
  CHECK(all >= 0.9 * 80);
  CHECK_TEXT(covered >= 0.9 * all, fmt::format("{} of {}", covered, all).c_str());
}

TEST(Identify, OneBranchIsEnoughForACellThatHasOne) {
  // A cell of R0 and one branch, written down directly.
  std::vector<double> plan = cell.pulse_plan(33.0, 400);
  CellLog log = cell.record(plan);
  double v1 = 0.0, soc = 1.0;
  for (std::size_t row = 0; row < plan.size(); ++row) {
    if (row > 0) {
      soc -= plan[row] / (3600.0 * cell.capacity_ah);
      v1 = 2e-3 * plan[row] + (v1 - 2e-3 * plan[row]) * std::exp(-1.0 / 40.0);
    }
    log.voltage_v[row] =
        KnownCell::em(soc) - 1.5e-3 * plan[row] - v1 + 1e-4 * std::sin(12.9898 * static_cast<double>(row));
  }
  options.branches = 0;
  const IdentifyResult r = identify({log}, options);
  LONGS_EQUAL(1, r.model.branches());
  DOUBLES_EQUAL(40.0, r.model.tau(8, 0), 2.0);
  DOUBLES_EQUAL(1.5e-3, r.model.r(8, 0), 3e-5);
}

TEST(Identify, TwoBranchesAreEnoughForACellThatHasTwo) {
  cell.noise_v = 3e-4;
  options.branches = 0;
  LONGS_EQUAL(2, identify(logs_of(cell.pulse_plan(33.0, 640, 0.0)), options).model.branches());
}

TEST(Identify, ACellOfThreeBranchesIsFoundAndPredictsADriveThreeTimesAsWellAsTwo) {
  cell.third_ohm = 0.9e-3;
  cell.noise_v = 3e-4;
  const std::vector<CellLog> pulses = logs_of(cell.pulse_plan(33.0, 640, 0.0));
  options.branches = 0;
  const IdentifyResult three = identify(pulses, options);
  LONGS_EQUAL(3, three.model.branches());
  LONGS_EQUAL(4, three.orders.size());
  for (Eigen::Index node = 3; node < three.model.grid.size() - 1; ++node) {
    DOUBLES_EQUAL(1.0, three.model.r(node, 1) / cell.third_ohm, 0.1);
    DOUBLES_EQUAL(1.0, three.model.tau(node, 0) / cell.third_tau_s, 0.15);
    DOUBLES_EQUAL(1.0, three.model.r(node, 3) / KnownCell::r2(three.model.grid.at(node)), 0.1);
  }
  options.branches = 2;
  const IdentifyResult two = identify(pulses, options);
  // Short and long steps, as a race has them.
  std::vector<double> drive(10, 0.0);
  for (int k = 0; k < 60; ++k) {
    const double current_a = k % 3 == 0 ? 0.0 : 25.0 + 30.0 * (k % 2);
    drive.insert(drive.end(), static_cast<std::size_t>(2 + 7 * k % 19), current_a);
  }
  cell.noise_v = 0.0;
  const CellLog log = cell.record(drive);
  const auto rms = [&](const IdentifyResult& found) {
    RunOptions at;
    at.hold = CurrentHold::kNext;
    at.capacity_ah = found.model.capacity_ah;
    at.anchor = {0, 1.0, "full"};
    const MeasuredRun run = make_run(log, at);
    return std::sqrt((simulate(found.model, run) - run.voltage_v).squaredNorm() / static_cast<double>(run.rows()));
  };
  const double with_three = rms(three), with_two = rms(two);
  CHECK_TEXT(with_two > 3.0 * with_three,
             fmt::format("{:.3f} and {:.3f} mV", 1e3 * with_two, 1e3 * with_three).c_str());
}

TEST(Identify, HoldIsFoundFromTheVoltageAlone) {
  options.hold.reset();
  // Rows every 30 s, each with the current that has held since the one before.
  const CellLog fine = cell.record(cell.pulse_plan(33.0, 600));
  CellLog coarse;
  coarse.path = "coarse";
  for (std::size_t row = 0; row < fine.rows(); ++row) {
    const bool step = row > 0 && fine.current_a[row] != fine.current_a[row - 1];
    const bool last = row + 1 < fine.rows() && fine.current_a[row + 1] != fine.current_a[row];
    if (row % 30 != 0 && !last && !(step && row % 2 == 0)) continue;
    coarse.time_s.push_back(fine.time_s[row]);
    coarse.current_a.push_back(fine.current_a[row]);
    coarse.voltage_v.push_back(fine.voltage_v[row]);
  }
  coarse.gap.assign(coarse.rows(), false);
  const IdentifyResult r = identify({coarse}, options);
  CHECK(r.files[0].hold == CurrentHold::kNext);
  STRCMP_EQUAL("its voltage", r.files[0].hold_from.c_str());
}

TEST(Identify, HoldThatTheVoltageDoesNotTellWidensTheIntervalOfR0) {
  const auto logs = logs_of(cell.pulse_plan(33.0, 400));
  const IdentifyResult declared = identify(logs, options);
  options.hold.reset();
  const IdentifyResult open = identify(logs, options);
  STRCMP_CONTAINS("does not tell", open.files[0].hold_from.c_str());
  const Eigen::Index r0 = open.model.em.size() + 8;
  // Six tenths of a row's time: R0 less that much of both branches' first rise.
  const double rise = 0.6 * (KnownCell::r1(0.5) / KnownCell::tau1(0.5) + KnownCell::r2(0.5) / KnownCell::tau2(0.5));
  const double added = std::sqrt(std::pow(open.uncertainty.sigma(r0), 2) - std::pow(declared.uncertainty.sigma(r0), 2));
  DOUBLES_EQUAL(1.0, added / (rise / KnownCell::r0(0.5)), 0.2);
  CHECK(declared.uncertainty.sigma(r0) < 0.5 * open.uncertainty.sigma(r0));
}

TEST(Identify, AThermometerThatMayBeLateWidensWhatAWarmingCellShows) {
  // 3 K to and fro in 400 s: what the cell had 15 s ago is up to 0.7 K off, two percent of a resistance. That makes 14
  // per mille of the 10 that the interval of R0 has without.
  auto logs = logs_of(cell.pulse_plan(33.0, 400));
  const auto r0_sigma = [&](double period_s) {
    CellLog& log = logs.front();
    log.temperature_c.clear();
    for (const double t : log.time_s) log.temperature_c.push_back(25.0 + 3.0 * std::sin(2.0 * M_PI * t / period_s));
    const IdentifyResult r = identify(logs, options);
    double square = 0.0;
    for (Eigen::Index node = 0; node < 16; ++node) square += std::pow(r.uncertainty.sigma(r.model.em.size() + node), 2);
    return std::sqrt(square / 16.0);
  };
  const double slow = r0_sigma(4000.0), quick = r0_sigma(400.0);
  CHECK_TEXT(std::sqrt(std::max(0.0, quick * quick - slow * slow)) > 12e-3, fmt::format("{} {}", slow, quick).c_str());
}

TEST(Identify, InstrumentLimitsWidenWhatTheyMove) {
  cell.noise_v = 5e-4;
  const auto logs = logs_of(cell.pulse_plan(33.0, 400));
  const IdentifyResult ideal = identify(logs, options);
  options.instruments.current_gain = 0.02;
  options.instruments.voltage_v = 5e-3;
  const IdentifyResult real = identify(logs, options);
  const Eigen::Index r0 = real.model.em.size() + 8, em = 30, tau1 = real.model.em.size() + 3 * 16 + 8;
  const auto added = [&](Eigen::Index at) {
    return std::sqrt(std::pow(real.uncertainty.sigma(at), 2) - std::pow(ideal.uncertainty.sigma(at), 2));
  };
  DOUBLES_EQUAL(0.02 / std::sqrt(3.0), added(r0), 1e-3);
  DOUBLES_EQUAL(5e-3 / std::sqrt(3.0), added(em), 1e-3);
  CHECK(added(tau1) < 0.005);
}

TEST(Identify, BlocksKeptBackArePredicted) {
  cell.noise_v = 5e-4;
  options.block_s = 60.0;
  const IdentifyResult r = identify(logs_of(cell.pulse_plan(33.0, 400)), options);
  CHECK(r.rms_other_blocks_v.has_value());
  CHECK(*r.rms_other_blocks_v < 1e-3);
  CHECK(*r.rms_other_blocks_v > 4e-4);
}

TEST(Identify, GlitchesAreNotUsedAndCounted) {
  CellLog log = cell.record(cell.pulse_plan(33.0, 400));
  for (std::size_t row = 500; row < log.rows(); row += 1500) log.voltage_v[row] -= 0.8;
  const IdentifyResult r = identify({log}, options);
  CHECK(r.rms_v < 1e-3);
  bool said = false;
  for (const std::string& note : r.notes) said |= note.find("rows that no circuit follows") != std::string::npos;
  CHECK(said);
}

TEST(Identify, AFullChargeAtTheEndTellsTheCapacityThatItPutsBack) {
  const double start_soc = 0.9, drawn_soc = 0.8, charge_a = 10.0;
  std::vector<double> plan = cell.pulse_plan(33.0, 500, 1.0 - drawn_soc);
  const double drawn_ah = std::accumulate(plan.begin(), plan.end(), 0.0) / 3600.0;
  const double back_ah = drawn_ah + (1.0 - start_soc) * cell.capacity_ah;
  plan.insert(plan.end(), static_cast<std::size_t>(std::lround(back_ah * 3600.0 / charge_a)), -charge_a);
  plan.insert(plan.end(), 1200, 0.0);
  const IdentifyResult result = identify({cell.record(plan, start_soc)}, options);
  DOUBLES_EQUAL(back_ah, result.model.capacity_ah, 0.01 * back_ah);
  DOUBLES_EQUAL(0.0, result.files[0].soc_low, 0.01);
  DOUBLES_EQUAL(1.0, result.files[0].soc_high, 0.01);
  CHECK(result.rms_v < 2e-3);
  CHECK(result.uncertainty.sigma.allFinite());
}

TEST(Identify, ARecorderOfOneRowInTenSecondsIsFitted) {
  const CellLog all = cell.record(cell.pulse_plan(33.0, 640, 0.0));
  CellLog slow;
  slow.path = "slow recorder";
  for (std::size_t row = 0; row < all.rows(); row += 10) {
    slow.time_s.push_back(all.time_s[row]);
    slow.current_a.push_back(all.current_a[row]);
    slow.voltage_v.push_back(all.voltage_v[row]);
  }
  slow.gap.assign(slow.rows(), false);
  const IdentifyResult r = identify({slow}, options);
  const double whole = r.model.r.row(8).sum(), truth = KnownCell::r0(0.5) + KnownCell::r1(0.5) + KnownCell::r2(0.5);
  DOUBLES_EQUAL(1.0, whole / truth, 0.1);
}

TEST(Identify, RowsBeyondAToldCapacityAreNotUsed) {
  const auto logs = logs_of(cell.pulse_plan(33.0, 640, 0.0));
  const double drawn_ah = identify(logs, options).model.capacity_ah;
  options.capacity_ah = 0.99 * drawn_ah;
  const IdentifyResult r = identify(logs, options);
  CHECK(r.files[0].soc_low < -0.005);
  CHECK(r.rms_v < 1e-3);
  const RecordingResult& file = r.files[0];
  for (std::size_t row = 0; row < file.used.size(); ++row) {
    if (file.trace.soc(static_cast<Eigen::Index>(row)) < -0.005) CHECK_FALSE(file.used[row]);
  }
}

TEST(Identify, AWarmingThatWasReckonedTellsNoLaw) {
  // Pulses at 3C without a thermometer, of a cell that keeps its heat.
  options.thermal = [](double) { return CellThermal{800.0, 0.05, 0.0}; };
  const IdentifyResult r = identify(logs_of(cell.pulse_plan(90.0, 600, 0.0)), options);
  CHECK(r.files[0].warmest_c > 27.0);
  CHECK(r.laws_assumed);
  DOUBLES_EQUAL(15.0, r.model.laws.ohmic_kj_per_mol, 1.0);
  for (const LawFact& fact : law_facts(r)) {
    if (fact.unit == "J/mol") CHECK(fact.origin == FactOrigin::kAssumed);
  }
}

TEST(Identify, RecordingWithoutCurrentOrWithoutChangeIsRefused) {
  STRCMP_CONTAINS("no current",
                  complaint([&] { (void)identify(logs_of(std::vector<double>(600, 0.0)), options); }).c_str());
  STRCMP_CONTAINS("never changes",
                  complaint([&] { (void)identify(logs_of(std::vector<double>(600, 30.0)), options); }).c_str());
}

TEST(Identify, SinglePulseGivesAModelWhoseFarNodesAreNotExcited) {
  std::vector<double> plan(600, 0.0);
  plan.insert(plan.end(), 360, 30.0);
  plan.insert(plan.end(), 1800, 0.0);
  options.capacity_ah = 30.0;
  const IdentifyResult r = identify(logs_of(plan), options);
  CHECK(is_excited(r, 0, 13));
  CHECK(!is_excited(r, 0, 5));
}
