// SPDX-License-Identifier: Apache-2.0
// A pedal that asks for more than the pack gives says nothing of the torque; one that asks for less says it.
#include <cmath>
#include <cstdlib>
#include <random>
#include <string>

#include "explain/model/cut_torque.hpp"

#include <CppUTest/TestHarness.h>

namespace voltlap::explain {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr Index kRows = 4000;
constexpr double kTorque_nm = 150.0, kConstant = 0.25, kVolts = 400.0, kRpm = 2.0 * M_PI / 60.0;

plant::World car() {
  plant::World out;
  out.car.inverter.current_max_a = kTorque_nm / kConstant;
  out.car.motor.constant_nm_per_a = kConstant;
  out.car.motor.efficiency = 1.0;
  out.car.motor.curve_speed_rpm = {0.0, 4000.0, 6000.0};
  out.car.motor.curve_torque_nm = {kTorque_nm, kTorque_nm, 60.0};
  return out;
}

/// Pedals and speeds as they come; the pack gives what is asked up to `limit_w`, which falls as it empties.
plant::Recording drive(std::mt19937& draw, const VectorXd& limit_w) {
  std::uniform_real_distribution<double> share(0.0, 1.0), rpm(500.0, 3900.0);
  plant::Recording log;
  log.time_s = VectorXd::LinSpaced(kRows, 0.0, 0.1 * (kRows - 1));
  for (const char* role : {"accelerator", "motor_speed", "current"}) log.signals[role] = VectorXd::Zero(kRows);
  log.signals["pack_voltage"] = VectorXd::Constant(kRows, kVolts);
  for (Index row = 0; row < kRows; ++row) {
    const bool anew = row % 20 == 0;
    double &pedal = log.signals["accelerator"](row), &turns = log.signals["motor_speed"](row);
    pedal = anew ? share(draw) : log.signals["accelerator"](row - 1);
    turns = anew ? rpm(draw) : log.signals["motor_speed"](row - 1);
    log.signals["current"](row) = std::min(limit_w(row), pedal * kTorque_nm * turns * kRpm) / kVolts;
  }
  return log;
}

}  // namespace

TEST_GROUP(CutTorque) {
  std::mt19937 draw;
  unsigned seed = 1;
  void setup() override {
    if (const char* given = std::getenv("VOLTLAP_TEST_SEED")) seed = static_cast<unsigned>(std::atoi(given));
    draw.seed(seed);
  }
};

TEST(CutTorque, NoRowIsKeptThatALimitHasCutAndMostOfTheOthersAre) {
  for (int k = 0; k < 20; ++k) {
    const double full_w = std::uniform_real_distribution<double>(10e3, 50e3)(draw),
                 left = std::uniform_real_distribution<double>(0.5, 1.0)(draw);
    const VectorXd limit_w = VectorXd::LinSpaced(kRows, full_w, left * full_w);
    const plant::Recording log = drive(draw, limit_w), out = without_cut_torque(car(), log);
    const VectorXd &asked = *log.find("accelerator"), &kept = *out.find("accelerator");
    double below = 0.0, known = 0.0;
    for (Index row = 0; row < kRows; ++row) {
      const double asked_w = asked(row) * kTorque_nm * (*log.find("motor_speed"))(row)*kRpm;
      const std::string where = "VOLTLAP_TEST_SEED=" + std::to_string(seed) + ", draw " + std::to_string(k) + ", row " +
                                std::to_string(row);
      if (std::isfinite(kept(row))) {
        DOUBLES_EQUAL_TEXT(asked(row), kept(row), 0.0, where.c_str());
        CHECK_TEXT(asked_w <= limit_w(row), where.c_str());
      }
      if (asked_w > 0.6 * limit_w(row)) continue;
      below += 1.0;
      known += std::isfinite(kept(row)) ? 1.0 : 0.0;
    }
    CHECK_TEXT(known > 0.9 * below, ("VOLTLAP_TEST_SEED=" + std::to_string(seed)).c_str());
  }
}

TEST(CutTorque, WhereTheMotorIsReadThePedalStaysAsItIs) {
  plant::Recording log = drive(draw, VectorXd::Constant(kRows, 5e3));
  log.signals["motor_torque"] = VectorXd::Constant(kRows, 20.0);
  CHECK(*without_cut_torque(car(), log).find("accelerator") == *log.find("accelerator"));
}

TEST(CutTorque, BeyondTheCurveASpeedThatNobodyReadTellsNothing) {
  plant::Recording log = drive(draw, VectorXd::Constant(kRows, 1e9));
  log.signals["motor_speed"].tail(kRows / 2).setConstant(5500.0);  // 82 Nm at most
  log.signals["accelerator"].tail(kRows / 2).setConstant(0.7);     // 105
  log.signals["current"].tail(kRows / 2).setConstant(1000.0);      // whatever: no limit
  CHECK(std::isfinite((*without_cut_torque(car(), log).find("accelerator"))(kRows - 1)));
  log.derived.insert("motor_speed");
  CHECK_FALSE(std::isfinite((*without_cut_torque(car(), log).find("accelerator"))(kRows - 1)));
}

}  // namespace voltlap::explain
