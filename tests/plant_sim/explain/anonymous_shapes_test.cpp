// SPDX-License-Identifier: Apache-2.0
// Shapes without a name that are as large as something that the log itself shows.
#include "explain/shapes/anonymous_shapes.hpp"

#include <cmath>

#include "explain/balances/model.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using Eigen::Index;
using Eigen::VectorXd;

TEST_GROUP(AnonymousShapes) {
  static constexpr Index kRows = 3000;  // 10 Hz
  static constexpr double kLag = 40.0, kAir = 12.0;

  /// Shapes of a cell that begins so many kelvin above the air.
  static std::vector<Shape> shapes(double above_k, double lag_s) {
    World model = load_model(DataFolder(VOLTLAP_DATA_FOLDER), "aesc_e5_2p", {}).world;
    model.car.cell.surface_lag_s = lag_s;
    Recording log;
    log.time_s = VectorXd::LinSpaced(kRows, 0.0, 0.1 * (kRows - 1));
    log.signals["current"] = 30.0 * (0.1 * log.time_s.array()).sin().matrix();
    log.signals["voltage"] = VectorXd::Constant(kRows, 3.9);
    log.signals["ambient"] = VectorXd::Constant(kRows, kAir);
    log.signals["temperature_1"] = VectorXd::Constant(kRows, kAir + above_k);
    const Comparison comparison = comparison_of(model, log, {});
    return anonymous_shapes({model, comparison, predict(model, comparison)});
  }

  static const Shape* rise(const std::vector<Shape>& all) {
    for (const Shape& shape : all) {
      if (shape.key == "temperature/rise at the beginning") return &shape;
    }
    return nullptr;
  }
};

TEST(AnonymousShapes, AWarmStartGrowsWithItsRiseAndWithTheLagOfTheSurface) {
  const auto four = shapes(4.0, kLag), two = shapes(-2.0, kLag);
  CHECK(rise(four) != nullptr && rise(two) != nullptr);
  const VectorXd &a = rise(four)->effect, &b = rise(two)->effect;
  DOUBLES_EQUAL(0.0, a(0), 1e-9);
  DOUBLES_EQUAL(4.0 * (1.0 - std::exp(-0.1 * (kRows - 1) / kLag)), a(kRows - 1), 1e-6);
  DOUBLES_EQUAL(-2.0, a(kRows - 1) / b(kRows - 1), 1e-6);
}

TEST(AnonymousShapes, AStartInTheAirsTemperatureOrACellWithoutALagHasNone) {
  CHECK(rise(shapes(0.0, kLag)) == nullptr);
  CHECK(rise(shapes(4.0, 0.0)) == nullptr);
}

TEST(AnonymousShapes, WhatARestSaysOfTheChargeIsAsSureAsTheVoltageIsSteepThere) {
  const World model = load_model(DataFolder(VOLTLAP_DATA_FOLDER), "aesc_e5_2p", {}).world;
  double slopes[2];
  std::size_t which = 0;
  for (const double volts : {3.7, 4.05}) {
    Recording log;
    log.time_s = VectorXd::LinSpaced(kRows, 0.0, 0.1 * (kRows - 1));
    log.signals["current"] = VectorXd::Zero(kRows);
    log.signals["current"].tail(kRows / 2).setConstant(20.0);
    log.signals["voltage"] = VectorXd::Constant(kRows, volts);
    log.signals["soc"] = VectorXd::Constant(kRows, 0.5);
    const Comparison comparison = comparison_of(model, log, {.judge_soc = true});
    const Prediction base = predict(model, comparison);
    const double slope = slopes[which++] = base.battery.ocv_slope_v(0);
    const Shape* level = nullptr;
    const std::vector<Shape> all = anonymous_shapes({model, comparison, base});
    for (const Shape& shape : all) {
      if (shape.key == "soc/1 at rest") level = &shape;
    }
    CHECK(level != nullptr);
    DOUBLES_EQUAL(1e-3, slope * level->effect(0), 1e-9);  // 1 mV
  }
  CHECK(slopes[0] < 0.8 * slopes[1] || slopes[1] < 0.8 * slopes[0]);
}
