// SPDX-License-Identifier: Apache-2.0
// What is worth a word in a channel of a log.
#include "explain/model/observed.hpp"

#include <CppUTest/TestHarness.h>

#include <cmath>
#include <random>
#include <string>

#include "explain/balances/model.hpp"
#include "explain/balances/recorded_motor.hpp"
#include "explain/model/unstepped.hpp"

namespace voltlap::explain {
namespace {

/// A drawn drive of pulls, as a logger of this interval between rows has it, whose sensor is quiet at rest.
plant::Comparison drive_at(double row_s, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> seconds(1.0, 4.0), pull(50.0, 300.0);
  plant::Comparison out;
  const auto rows = static_cast<Index>(400.0 / row_s);
  out.log.time_s = VectorXd::LinSpaced(rows, 0.0, row_s * static_cast<double>(rows - 1));
  out.facts.current_a = VectorXd::Zero(rows);
  double until = 0.0, amperes = 0.0;
  for (Index row = 0; row < rows; ++row) {
    while (out.log.time_s(row) >= until) until += seconds(random), amperes = amperes > 0.0 ? 0.0 : pull(random);
    out.facts.current_a(row) = amperes;
  }
  return out;
}

double practical(const std::string& channel, const plant::Comparison& comparison, const plant::Recording& read,
                 double drop_v = 0.0) {
  Observed log;
  log.comparison = comparison;
  log.read = read;
  log.base.battery.drop_v = VectorXd::Constant(comparison.log.time_s.size(), drop_v);
  return practical_size(channel, log);
}

double practical_v(const plant::Comparison& comparison, double drop_v = 0.0) {
  return practical("voltage", comparison, comparison.log, drop_v);
}

/// A test of pulses, one row a second: each begins in the same half of the rows and ends in a drawn one.
Observed pulses(unsigned seed, bool even) {
  const plant::World model = plant::load_model(plant::DataFolder(VOLTLAP_DATA_FOLDER), "aesc_e5_2p", {}).world;
  constexpr Index kRows = 6000, kPeriod = 140;
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> amperes(10, 70);
  const Index seconds = std::uniform_int_distribution<Index>(10, 16)(random);
  plant::Recording log;
  log.time_s = VectorXd::LinSpaced(kRows, 0.0, kRows - 1.0);
  VectorXd& current = log.signals["current"];
  current = VectorXd::Zero(kRows);
  for (Index row = even ? 60 : 61; row + seconds < kRows; row += kPeriod)
    current.segment(row, seconds).setConstant(amperes(random));
  log.signals["voltage"] = VectorXd::Constant(kRows, 3.9);
  const plant::Comparison blank = plant::comparison_of(model, log, {});
  log.signals["voltage"] = plant::predict(model, blank).channels[0];
  return observed(model, plant::comparison_of(model, std::move(log), {}));
}

}  // namespace

TEST_GROUP(Observed){};

TEST(Observed, PulsesThatBeginInOneHalfOfTheRowsAreNoChargeThatNobodyKnows) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    for (const bool even : {true, false}) {
      const double off = pulses(seed, even).channels.front().between_rows;
      CHECK_TEXT(off < 0.8, (std::to_string(seed) + ": " + std::to_string(off)).c_str());
    }
  }
}

TEST(Observed, WhereThePullsLieBetweenTheRowsAVoltageIsWorthAWordLater) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    DOUBLES_EQUAL(1e-3, practical_v(drive_at(0.01, seed)), 1e-12);
    DOUBLES_EQUAL(1e-3, practical_v(drive_at(0.1, seed)), 1e-12);
    DOUBLES_EQUAL(3e-3, practical_v(drive_at(2.0, seed)), 1e-12);
  }
}

TEST(Observed, ATestAtOneCurrentMayBeLoggedSeldom) {
  plant::Comparison test = drive_at(60.0, 1);
  test.facts.current_a.setConstant(30.0);
  DOUBLES_EQUAL(1e-3, practical_v(test), 1e-12);
  test.facts.current_a.setZero();
  DOUBLES_EQUAL(1e-3, practical_v(test), 1e-12);
}

TEST(Observed, WhatACurrentTakesIsKnownToATwoHundredth) {
  const plant::Comparison test = drive_at(0.1, 1);
  DOUBLES_EQUAL(1e-3, practical_v(test, 0.1), 1e-12);
  DOUBLES_EQUAL(2e-3, practical_v(test, 0.4), 1e-12);
}

TEST(Observed, StepsThatWerePassedMakeNoTemperatureCoarse) {
  plant::Comparison log = drive_at(0.5, 1);
  const Index rows = log.log.time_s.size();
  VectorXd& read = log.log.signals["temperature_1"];
  read = VectorXd::LinSpaced(rows, 22.2, 27.9);
  for (double& value : read) value = std::round(value);
  const plant::Recording taken_away = unstepped(log.log);
  DOUBLES_EQUAL(0.1, practical("temperature", log, taken_away), 1e-12);
  DOUBLES_EQUAL(1.0 / std::sqrt(12.0), practical("temperature", log, log.log), 1e-12);
  CHECK(is_coarse(read));
  CHECK_FALSE(is_coarse(VectorXd::Constant(5, 21.0)));
}

TEST(Observed, SpeedIsKnownTheWorseTheFurtherRowsAreApartPowerIsNot) {
  for (const char* channel : {"power", "speed"}) {
    plant::Comparison fine = drive_at(0.01, 1), coarse = drive_at(0.1, 1);
    for (plant::Comparison* log : {&fine, &coarse}) {
      const plant::Balance balance = std::string(channel) == "power" ? plant::Balance::kPower : plant::Balance::kForce;
      log->channels.push_back({channel, balance, "", VectorXd::Constant(log->log.time_s.size(), 200.0)});
    }
    const auto worth = [&](const plant::Comparison& log) {
      return practical(channel, log, log.log);
    };
    DOUBLES_EQUAL(1.0, worth(fine), 1e-9);
    DOUBLES_EQUAL(std::string(channel) == "power" ? 1.0 : 3.0, worth(coarse), 1e-9);
  }
}

TEST(Observed, WithoutAMotorSpeedAndItsCornersPowerIsKnownNoBetterThanWhatTyresSlip) {
  plant::Comparison log = drive_at(0.05, 1);
  const Index rows = log.log.time_s.size();
  constexpr double kSpeed = 15.0, kSlip = 0.03, kPower = 200.0;
  const plant::World world = plant::load_model(plant::DataFolder(VOLTLAP_DATA_FOLDER), "vtm16e", {}).world;
  const double rolling = kSpeed * world.car.powertrain.final_drive / world.car.tyres.radius_m / plant::kRpm;
  log.channels.push_back({"power", plant::Balance::kPower, "", VectorXd::Constant(rows, kPower)});
  log.log.signals["speed"] = VectorXd::Constant(rows, kSpeed);
  log.log.signals["motor_speed"] = VectorXd::Constant(rows, rolling * (1.0 + kSlip));
  const auto worth = [&](double cornering) {
    Observed seen;
    seen.model = world;
    seen.model.car.tyres.cornering_stiffness_per_rad = cornering;
    seen.comparison = log;
    seen.read = log.log;
    seen.base.battery.drop_v = VectorXd::Zero(rows);
    return practical_size("power", seen);
  };
  DOUBLES_EQUAL(0.005 * kPower, worth(20.0), 1e-9);  // it was read
  log.log.derived.insert("motor_speed");
  DOUBLES_EQUAL(kSlip * kPower, worth(20.0), 1e-6);
  DOUBLES_EQUAL(0.005 * kPower, worth(0.0), 1e-9);
  log.log.signals["lateral_acceleration"] = VectorXd::Zero(rows);
  DOUBLES_EQUAL(0.005 * kPower, worth(20.0), 1e-9);
}

}  // namespace voltlap::explain
