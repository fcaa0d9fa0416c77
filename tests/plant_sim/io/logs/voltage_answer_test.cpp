// SPDX-License-Identifier: Apache-2.0
#include "io/logs/voltage_answer.hpp"

#include <cmath>
#include <random>

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(VoltageAnswer) {
  std::mt19937 random{7};
  std::vector<double> current, voltage;
  void setup() override {
    std::uniform_real_distribution<double> amperes(-20.0, 200.0);
    for (int k = 0; k < 2000; ++k) {
      if (k % 5 == 0)
        current.push_back(amperes(random));
      else
        current.push_back(current.back());
      voltage.push_back(100.0 - 0.03 * current.back() - 0.002 * k);
    }
  }
};

TEST(VoltageAnswer, TheSlopeIsTheResistance) {
  const VoltageAnswer answer = voltage_answer(current, voltage);
  DOUBLES_EQUAL(-0.03, answer.slope[0], 1e-3);  // the largest steps are clipped
  CHECK(answer.clearest() < -0.999);
  CHECK(answer.steps > 300);
}

TEST(VoltageAnswer, WhatDoesNotMoveWithTheVoltageDoesNotAnswer) {
  std::vector<double> other;
  std::uniform_real_distribution<double> any(0.0, 1.0);
  for (std::size_t k = 0; k < current.size(); ++k) other.push_back(any(random));
  CHECK(std::abs(voltage_answer(other, voltage).clearest()) < 0.2);
}

TEST(VoltageAnswer, HolesAndASpikeDoNotDecide) {
  voltage[500] = 6000.0;
  for (std::size_t k = 0; k < voltage.size(); k += 3) voltage[k] = std::nan("");
  CHECK(voltage_answer(current, voltage).correlation[1] < -0.9);
}

TEST(VoltageAnswer, NothingComesOfWhatStandsStill) {
  const std::vector<double> still(current.size(), 3.0);
  const VoltageAnswer answer = voltage_answer(still, voltage);
  DOUBLES_EQUAL(0.0, answer.clearest(), 0.0);
  UNSIGNED_LONGS_EQUAL(0, answer.steps);
}
