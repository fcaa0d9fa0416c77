// SPDX-License-Identifier: Apache-2.0
// Shapes without a name that are as large as something that the log itself shows.
#include "discrepancy/anonymous_shapes.hpp"

#include <cmath>

#include "discrepancy/causes/list.hpp"
#include "discrepancy/model.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using Eigen::Index;
using Eigen::VectorXd;

TEST_GROUP(AnonymousShapes) {
  static constexpr Index kRows = 3000;  // 10 Hz
  static constexpr double kLag = 40.0, kAir = 12.0;

  /// Columns of a cell that begins so many kelvin above the air.
  static std::vector<Column> columns(double above_k, double lag_s) {
    World model = load_model(DataFolder(VOLTLAP_DATA_FOLDER), "aesc_e5_2p", {}).world;
    model.car.cell.surface_lag_s = lag_s;
    Recording log;
    log.time_s = VectorXd::LinSpaced(kRows, 0.0, 0.1 * (kRows - 1));
    log.signals["current"] = 30.0 * (0.1 * log.time_s.array()).sin().matrix();
    log.signals["voltage"] = VectorXd::Constant(kRows, 3.9);
    log.signals["ambient"] = VectorXd::Constant(kRows, kAir);
    log.signals["temperature_1"] = VectorXd::Constant(kRows, kAir + above_k);
    return anonymous_columns(design_of(model, comparison_of(model, log, {}), catalogue({})));
  }

  static const Column* rise(const std::vector<Column>& all) {
    for (const Column& column : all) {
      if (column.key == "anonymous/temperature/rise at the beginning") return &column;
    }
    return nullptr;
  }
};

TEST(AnonymousShapes, AWarmStartGrowsWithItsRiseAndWithTheLagOfTheSurface) {
  const auto four = columns(4.0, kLag), two = columns(-2.0, kLag);
  CHECK(rise(four) != nullptr && rise(two) != nullptr);
  const VectorXd &a = rise(four)->effect[1], &b = rise(two)->effect[1];
  DOUBLES_EQUAL(0.0, a(0), 1e-9);
  DOUBLES_EQUAL(4.0 * (1.0 - std::exp(-0.1 * (kRows - 1) / kLag)), a(kRows - 1), 1e-6);
  DOUBLES_EQUAL(-2.0, a(kRows - 1) / b(kRows - 1), 1e-6);
  CHECK(rise(four)->of_start);
}

TEST(AnonymousShapes, AStartInTheAirsTemperatureOrACellWithoutALagHasNone) {
  CHECK(rise(columns(0.0, kLag)) == nullptr);
  CHECK(rise(columns(4.0, 0.0)) == nullptr);
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
    const Design design = design_of(model, comparison_of(model, log, {.judge_soc = true}), catalogue({}));
    const double slope = slopes[which++] = design.base.battery.ocv_slope_v(0);
    const Column *level = nullptr, *start = nullptr;
    for (const Column& column : design.columns) {
      if (column.key == "anonymous/soc/1 at rest") level = &column;
      if (column.key == "start/soc") start = &column;
    }
    CHECK(level != nullptr && start != nullptr);
    DOUBLES_EQUAL(1e-3, slope * level->effect[1](0), 1e-9);  // 1 mV
    // 0.7 mV, in the hundredths of the charge that the column is of
    DOUBLES_EQUAL(0.7e-3, slope * start->free * 0.01, 1e-9);
  }
  CHECK(slopes[0] < 0.8 * slopes[1] || slopes[1] < 0.8 * slopes[0]);
}
