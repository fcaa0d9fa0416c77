// SPDX-License-Identifier: Apache-2.0
// A pile of readings at the end of a current is a limit of its sensor where the voltage sags beyond what it gives; a
// limit of the battery where the voltage agrees with it.
#include "discrepancy/saturation.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "discrepancy/model.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr Index kRows = 6000;  // 10 Hz
constexpr double kLimit = 60.0, kNoise = 0.15, kVoltageNoise = 5e-4;  // A, V

World leaf() {
  return load_model(DataFolder(VOLTLAP_DATA_FOLDER), "aesc_e5_2p", {}).world;
}

/// Pulls of 40 to 110 A, with rests between them.
VectorXd pulls(double sign) {
  VectorXd out(kRows);
  for (Index row = 0; row < kRows; ++row) {
    const double t = 0.1 * static_cast<double>(row);
    out(row) = t < 30.0 ? 0.0 : sign * std::max(0.0, (75.0 + 35.0 * std::sin(0.11 * t)) * std::sin(0.7 * t));
  }
  return out;
}

VectorXd clipped(VectorXd current) {
  for (double& i : current) i = std::clamp(i, -kLimit, kLimit);
  return current;
}

VectorXd with_noise(VectorXd values, double sigma) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0.0, sigma);
  for (double& v : values) v += noise(random);
  return values;
}

/// What a model of a cell would show under `flowed`, logged beside the readings of a sensor.
Comparison log_of(const World& model, const VectorXd& flowed, const VectorXd& read) {
  Recording log;
  log.time_s = VectorXd::LinSpaced(kRows, 0.0, 0.1 * (kRows - 1));
  log.signals["current"] = flowed;
  log.signals["voltage"] = VectorXd::Constant(kRows, 3.9);
  const Prediction truth = predict(model, comparison_of(model, log, {.hold = CurrentHold::kLinear}));
  log.signals["voltage"] = with_noise(truth.channels[0], kVoltageNoise);
  log.signals["current"] = with_noise(read, kNoise);
  return comparison_of(model, log, {.hold = CurrentHold::kLinear});
}

}  // namespace

TEST_GROUP(Saturation) {};

TEST(Saturation, a_pile_of_noisy_readings_at_the_end_is_a_rail_and_the_peak_of_a_pull_is_none) {
  const VectorXd current = with_noise(clipped(pulls(1.0)), kNoise);
  const auto rail = rail_of(current);
  CHECK(rail.has_value());
  DOUBLES_EQUAL(kLimit, rail->limit_a, 0.05);
  DOUBLES_EQUAL(kNoise, rail->noise_a, 0.05);
  for (Index row = 0; row < kRows; ++row) {
    if (pulls(1.0)(row) > kLimit) CHECK(rail->at[static_cast<std::size_t>(row)]);
  }
  CHECK_FALSE(rail_of(with_noise(pulls(1.0), kNoise)).has_value());
}

TEST(Saturation, a_pile_is_as_wide_as_the_noise_that_the_sensor_has_at_rest) {
  constexpr double kWide = 0.7;  // A: what lies within three of it is 7 % of the limit
  const auto rail = rail_of(with_noise(clipped(pulls(1.0)), kWide));
  CHECK(rail.has_value());
  DOUBLES_EQUAL(kLimit, rail->limit_a, kWide);
  CHECK_FALSE(rail_of(with_noise(pulls(1.0), kWide)).has_value());
}

TEST(Saturation, a_rest_that_reads_a_step_below_zero_is_no_rail_beside_a_limit) {
  constexpr double kStep = 0.9;
  VectorXd current = with_noise(clipped(pulls(1.0)), kNoise);
  for (Index row = 0; row < kRows; ++row) {
    const bool low = row % 3 == 0 && std::abs(current(row)) < 1.0;  // between two steps
    current(row) = low ? -kStep : kStep * std::round(current(row) / kStep);
  }
  CHECK((current.array() == -kStep).count() > 100);
  const auto rail = rail_of(current);
  CHECK(rail.has_value());
  DOUBLES_EQUAL(kLimit, rail->limit_a, 0.5 * kStep);
  DOUBLES_EQUAL(kStep, rail->step_a, 1e-9);
}

TEST(Saturation, the_uppermost_of_coarse_steps_is_no_rail_of_its_own) {
  constexpr double kStep = 0.5, kMiddle = 60.2;
  const auto read = [kStep](const VectorXd& values) { return VectorXd((values / kStep).array().round() * kStep); };
  const VectorXd limited = pulls(1.0).cwiseMin(kMiddle);
  const auto rail = rail_of(read(with_noise(limited, 0.3)));
  CHECK(rail.has_value());
  DOUBLES_EQUAL(kMiddle, rail->limit_a, 0.5 * kStep);
  for (Index row = 0; row < kRows; ++row) {
    if (pulls(1.0)(row) > kMiddle) CHECK(rail->at[static_cast<std::size_t>(row)]);
  }
  CHECK_FALSE(rail_of(read(with_noise(pulls(1.0), 0.3))).has_value());
}

TEST(Saturation, readings_that_are_all_alike_say_where_it_ends_to_half_a_step) {
  constexpr double kStep = 0.7;
  const World model = leaf();
  const VectorXd flowed = pulls(1.0), read = ((clipped(flowed) / kStep).array().round() * kStep).matrix();
  Comparison c = log_of(model, flowed, read);
  c.log.signals["current"] = read;
  const auto found = saturation_of(model, comparison_of(model, c.log, {.hold = CurrentHold::kLinear}));
  CHECK(found.has_value());
  const auto limit = found_saturation(*found).parameters.front();
  DOUBLES_EQUAL(0.5 * kStep, limit.high - limit.value, 1e-6);
  CHECK(limit.low <= kLimit && kLimit <= limit.high);
}

TEST(Saturation, a_small_pile_above_many_large_readings_is_a_rail_when_it_is_three_times_as_dense) {
  const auto current = [](double times) {  // `times` as many in the pile's 0.7 A as in the 0.7 A below it
    constexpr Index kPile = 280;
    constexpr double kWidth = 0.7;
    const double each = times * kWidth / static_cast<double>(kPile);  // A from one reading to the next
    VectorXd out(kRows);
    for (Index row = 0; row < kRows; ++row) {
      out(row) = row < kPile ? kLimit : std::max(0.0, kLimit - each * static_cast<double>(row - kPile));
    }
    return with_noise(out, kNoise);
  };
  const auto rail = rail_of(current(5.5));
  CHECK(rail.has_value());
  DOUBLES_EQUAL(kLimit, rail->limit_a, 0.1);
  CHECK_FALSE(rail_of(current(1.5)).has_value());
}

TEST(Saturation, what_flowed_beyond_the_limit_is_told_by_the_voltage_for_either_sign) {
  const World model = leaf();
  for (const double sign : {1.0, -1.0}) {
    const VectorXd flowed = pulls(sign);
    Comparison c = log_of(model, flowed, clipped(flowed));
    const auto found = saturation_of(model, c);
    CHECK(found.has_value());
    DOUBLES_EQUAL(kLimit, found->rail.limit_a, 0.05);
    World limited = model;
    limited.current_limit_a = found->rail.from_a;
    c.facts.at_limit = found->rail.at;
    const BatteryResponse is = battery_response(limited, c.log, c.facts);
    const double parallel = model.car.battery.cells_in_parallel;
    const VectorXd wrong = is.current_a * parallel - flowed;
    DOUBLES_EQUAL(0.0, std::sqrt(wrong.squaredNorm() / kRows), 0.01 * kLimit);
    DOUBLES_EQUAL(1.0, (is.current_a * parallel).sum() / flowed.sum(), 0.005);  // the charge
  }
}

TEST(Saturation, a_battery_that_is_held_at_a_limit_has_a_rail_but_no_saturation_even_with_another_resistance) {
  const World model = leaf();
  for (const double more : {0.0, 1e-3}) {
    World truth = model;
    truth.car.cell.effects.series_ohm = more;
    const VectorXd held = clipped(pulls(1.0));
    Comparison c = log_of(truth, held, held);
    CHECK(rail_of(*c.log.find("current")).has_value());
    CHECK_FALSE(saturation_of(model, c).has_value());
  }
}

TEST(Saturation, rows_at_the_limit_are_no_evidence_of_the_voltage) {
  const World model = leaf();
  const VectorXd flowed = pulls(1.0);
  const Comparison c = log_of(model, flowed, clipped(flowed));
  const auto found = saturation_of(model, c);
  CHECK(found.has_value());
  const Comparison masked = comparison_of(model, c.log, {.at_limit = found->rail.at});
  for (Index row = 0; row < kRows; ++row) {
    CHECK_EQUAL(found->rail.at[static_cast<std::size_t>(row)], std::isnan(masked.channels[0].measured(row)));
  }
  std::vector<Masked> said;
  mask_rail(*found, c.log, said);
  CHECK(!said.empty() && said.front().channel == "current");
}
