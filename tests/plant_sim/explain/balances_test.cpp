// SPDX-License-Identifier: Apache-2.0
// What a log tells before any cause is weighed: its rests, its SOC, and the heat that its own voltage means.
#include "explain/balances/balances.hpp"

#include <cmath>
#include <random>
#include <string>

#include "explain/balances/model.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr Index kRows = 3000, kRest = 600, kDriven = 2400;    // 10 Hz: a rest, 3 min of 20 A, a rest
constexpr double kLoad = 20.0, kOffset = 0.3, kNoise = 0.15;  // A

World leaf() {
  return load_model(DataFolder(VOLTLAP_DATA_FOLDER), "aesc_e5_2p", {}).world;
}

/// As the model itself would have it, but for the sensor's noise and offset; `soc` as it is predicted, less `low`.
Recording log_of(const World& model, double low, double load_a = kLoad) {
  Recording log;
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0.0, kNoise);
  log.time_s = VectorXd::LinSpaced(kRows, 0.0, 0.1 * (kRows - 1));
  VectorXd& current = log.signals["current"];
  current = VectorXd::Zero(kRows);
  for (Index row = 0; row < kRows; ++row) {
    current(row) = (row >= kRest && row < kDriven ? load_a : 0.0) + kOffset + noise(random);
  }
  log.signals["voltage"] = VectorXd::Constant(kRows, 3.9);
  log.signals["soc"] = VectorXd::Constant(kRows, 0.5);
  const Comparison blank = comparison_of(model, log, {.judge_soc = true});
  const Prediction expected = predict(model, blank);
  log.signals["voltage"] = expected.channels[0];
  log.signals["soc"] = (expected.battery.soc.array() - low).matrix();
  return log;
}

double mean_residual(const World& model, const Comparison& c, const char* name) {
  const Prediction p = predict(model, c);
  for (std::size_t k = 0; k < c.channels.size(); ++k) {
    if (c.channels[k].name == name) return (c.channels[k].measured - p.channels[k]).mean();
  }
  FAIL("no such channel");
  return NAN;
}

}  // namespace

TEST_GROUP(Balances){};

TEST(Balances, the_noise_of_the_current_is_averaged_at_rest_and_its_offset_stays) {
  const World model = leaf();
  const Comparison c = comparison_of(model, log_of(model, 0.0), {});
  const VectorXd rest = c.facts.current_a.head(kRest);
  DOUBLES_EQUAL(kOffset, rest.mean(), 0.03);
  CHECK((rest.array() - rest.mean()).matrix().norm() / std::sqrt(double{kRest}) < kNoise / 4.0);
  CHECK(c.facts.at_rest[kRest / 2]);
  CHECK_FALSE(c.facts.at_rest[(kRest + kDriven) / 2]);
  DOUBLES_EQUAL((*c.log.find("current"))(1000), c.facts.current_a(1000), 0.0);
}

TEST(Balances, a_rest_whose_readings_flicker_by_a_coarse_step_is_one_rest) {
  constexpr double kStep = 0.5;  // A; more than 2 % of the largest current, and most neighbours are equal
  const World model = leaf();
  const Recording fine = log_of(model, 0.0);
  for (const Index first : {0, 1, 100}) {  // row that reads one step more
    Recording log = fine;
    VectorXd& current = log.signals["current"];
    for (double& amps : current) amps = kStep * std::round((amps - kOffset) / kStep);
    current(first) = kStep;
    const Comparison c = comparison_of(model, log, {.judge_soc = true});
    CHECK(c.find("soc") != nullptr);
    CHECK(c.facts.starts_at_rest);
    for (Index row = 0; row < kRest; ++row) CHECK(c.facts.at_rest[static_cast<std::size_t>(row)]);
    DOUBLES_EQUAL(log.find("current")->head(kRest).mean(), c.facts.rest_current_a, 1e-9);
    CHECK(c.facts.current_a.head(kRest).maxCoeff() < 0.5 * kStep);
  }
}

TEST(Balances, how_the_current_is_held_is_as_told_where_the_logger_is_known) {
  const World model = leaf();
  const Recording log = log_of(model, 0.0);
  for (const CurrentHold hold : {CurrentHold::kLinear, CurrentHold::kPrevious, CurrentHold::kNext}) {
    CHECK(comparison_of(model, log, {.hold = hold}).facts.hold == hold);
  }
}

TEST(Balances, the_soc_of_a_log_is_a_channel_only_where_it_is_asked_for) {
  const World model = leaf();
  const Recording log = log_of(model, 0.0);
  CHECK(comparison_of(model, log, {}).find("soc") == nullptr);
  CHECK(comparison_of(model, log, {.judge_soc = true}).find("soc") != nullptr);
}

TEST(Balances, a_log_that_begins_too_low_shows_it_in_its_soc) {
  World model = leaf();
  const Comparison c = comparison_of(model, log_of(model, 0.02), {.judge_soc = true});
  const double seen = mean_residual(model, c, "soc");
  model.reported_soc_low = 0.02;
  DOUBLES_EQUAL(seen + 0.02, mean_residual(model, c, "soc"), 1e-12);
  CHECK(std::abs(mean_residual(model, c, "soc")) < 0.002);
}

TEST(Balances, a_soc_that_is_counted_from_the_log_does_not_see_the_capacity) {
  World model = leaf();
  const Comparison c = comparison_of(model, log_of(model, 0.0), {.judge_soc = true});
  const double sound = mean_residual(model, c, "soc");
  World counted = model;
  counted.soc_is_counted = true;
  counted.counted_ah = model.car.cell.capacity_ah;
  counted.car.cell.capacity_ah *= 0.9;
  DOUBLES_EQUAL(sound, mean_residual(counted, c, "soc"), 1e-9);
  model.car.cell.capacity_ah *= 0.9;
  CHECK(std::abs(mean_residual(model, c, "soc") - sound) > 1e-3);
}

TEST(Balances, a_log_that_begins_under_load_begins_with_the_charge_that_its_first_minute_tells) {
  const World model = leaf();
  Recording log = log_of(model, 0.0);
  const double soc = predict(model, comparison_of(model, log, {})).battery.soc(kRest);
  log.signals.erase("soc");
  const Index left = kRows - kRest;
  log.time_s = log.time_s.tail(left).eval();
  for (auto& [role, values] : log.signals) values = values.tail(left).eval();
  const Comparison c = comparison_of(model, log, {});
  CHECK_FALSE(c.facts.starts_at_rest);
  CHECK(soc < 0.9);  // a cell file alone says 1
  DOUBLES_EQUAL(soc, c.facts.initial_soc, 5e-4);
}

TEST(Balances, a_published_voltage_that_is_wrong_does_not_make_the_bus_wrong) {
  World model = leaf();
  model.car.battery.cells_in_series = 2;
  Recording log = log_of(model, 0.0);
  const VectorXd sum = *log.find("voltage");
  log.signals["cell_voltage_1"] = log.signals["cell_voltage_2"] = 0.5 * sum;
  log.signals.erase("voltage");
  World wrong = model;
  wrong.published_compensation_ohm = 5e-3;
  wrong.voltage = {0.01, 0.5, 0.2};  // V, s
  const VectorXd current = *log.find("current");
  const VectorXd terminals = sum - model.pack_resistance_ohm * current;
  log.signals["bus_voltage"] = terminals - model.car.contactors.resistance_ohm * current;
  log.signals["pack_voltage"] = terminals;
  const Comparison sound = comparison_of(model, log, {});
  const VectorXd published = predict(wrong, sound).channels[1];
  CHECK((published - terminals).mean() > 0.4);
  log.signals["pack_voltage"] = published;
  DOUBLES_EQUAL(0.0, mean_residual(wrong, comparison_of(model, log, {}), "bus_voltage"), 1e-3);
  CHECK(mean_residual(model, comparison_of(model, log, {}), "bus_voltage") < -0.4);
}

TEST(Balances, a_published_voltage_behind_a_filter_does_not_make_the_bus_wrong) {
  World model = leaf();
  model.car.battery.cells_in_series = 1;
  Recording log = log_of(model, 0.0);
  const VectorXd volts = *log.find("voltage"), current = *log.find("current");
  log.signals.erase("voltage");
  World wrong = model;
  wrong.published_compensation_ohm = 5e-3;
  wrong.published_tau_s = 3.0;
  wrong.published_filtered = 1.0;
  log.signals["bus_voltage"] = volts - model.car.contactors.resistance_ohm * current;
  log.signals["pack_voltage"] = volts;
  const Comparison sound = comparison_of(model, log, {});
  const VectorXd published = predict(wrong, sound).channels[0];
  CHECK((published - volts).cwiseAbs().maxCoeff() > 0.1);
  const VectorXd filtered = lagged(log.time_s, volts + 5e-3 * current, 3.0);
  CHECK((published - filtered).tail(published.size() / 2).cwiseAbs().maxCoeff() < 1e-3);
  log.signals["pack_voltage"] = published;
  DOUBLES_EQUAL(0.0, mean_residual(wrong, comparison_of(model, log, {}), "bus_voltage"), 1e-3);
}

/// R0 two seconds after 200 A, of which `rest_a` is read, over R0 before; of the cell R0 falls by 340 ppm an ampere.
double resistance_kept(double floor_a, double rest_a) {
  World model = leaf();
  model.car.battery.lookup_current_floor_a = floor_a;
  Recording log = log_of(model, 0.0);
  VectorXd& current = log.signals["current"];
  for (Index row = 0; row < kRows; ++row)
    current(row) = row >= kRest && row < kDriven ? 200.0 : (row % 2 == 0 ? rest_a : -rest_a);
  const VectorXd r0 = predict(model, comparison_of(model, log, {})).battery.r0_ohm;
  return r0(kDriven + 20) / r0(kDriven - 1);
}

TEST(Balances, what_is_read_of_no_current_is_no_current_at_which_a_resistance_is_asked) {
  for (const double rest_a : {0.0, 0.02, 0.1}) DOUBLES_EQUAL(1.0, resistance_kept(0.0, rest_a), 1e-3);
  // A car's floor, through which its current fell between two rows: R0 of 60 A over that of 200 A.
  DOUBLES_EQUAL(1.0 + 140.0 * 340e-6, resistance_kept(60.0, 0.0), 3e-3);
}

TEST(Balances, heat_follows_the_measured_voltage_and_not_the_resistances) {
  World model = leaf();
  Recording log = log_of(model, 0.0);
  const Comparison c = comparison_of(model, log, {});
  const double warm = predict(model, c).battery.temperature_c(kDriven);
  for (double& r : model.car.cell.r0_ohm.value) r *= 2.0;
  for (double& r : model.car.cell.r0_ohm.table) r *= 2.0;
  // What the branches store is not heat yet; how much that is follows the resistances.
  DOUBLES_EQUAL(warm, predict(model, c).battery.temperature_c(kDriven), 1e-4);
}

TEST(Balances, the_first_rest_is_read_by_the_world_that_explains_the_log) {
  const World model = leaf();
  const Comparison sound = comparison_of(model, log_of(model, 0.0, 10.0 * kLoad), {.judge_soc = true});
  const double soc = predict(model, sound).battery.soc(0);
  for (const auto& apply : {+[](World& w) { w.voltage.offset = 0.02; }, +[](World& w) { w.current.offset = 3.0; },
                            +[](World& w) { w.car.cell.effects.ocv_change_v = {0.01, 0.01}; },
                            +[](World& w) { w.car.cell.effects.entropy_v_per_k = 1e-3; }}) {
    World wrong = model;
    apply(wrong);
    Recording log = sound.log;
    log.signals["temperature_1"] = VectorXd::Constant(kRows, model.car.cell.reference_temperature_c + 12.0);
    log.signals["voltage"] =
        (log.signals["voltage"].array() + wrong.voltage.offset +
         (wrong.car.cell.effects.ocv_change_v.empty() ? 0.0 : 0.01) + 12.0 * wrong.car.cell.effects.entropy_v_per_k)
            .matrix();
    log.signals["current"].array() += wrong.current.offset;
    const Comparison seen = comparison_of(model, log, {.judge_soc = true});
    DOUBLES_EQUAL(soc, predict(wrong, seen).battery.soc(0), 1e-4);
    CHECK(std::abs(predict(model, seen).battery.soc(0) - soc) > 2e-3);
    CHECK(std::abs(mean_residual(wrong, seen, "soc")) < 0.2 * std::abs(mean_residual(model, seen, "soc")));
  }
}

TEST(Balances, a_thermistor_that_reads_too_much_is_right_in_the_world_that_says_so) {
  const World model = leaf();
  Recording log = log_of(model, 0.0);
  const VectorXd warming = VectorXd::LinSpaced(kRows, 22.0, 28.0);
  log.signals["temperature_1"] = warming;
  const Comparison sound = comparison_of(model, log, {});
  log.signals["temperature_1"] = (warming.array() + 6.0).matrix();
  World wrong = model;
  wrong.thermistor_offset_k = 6.0;
  const Comparison seen = comparison_of(model, log, {});
  for (const char* channel : {"voltage", "temperature"}) {
    DOUBLES_EQUAL(mean_residual(model, sound, channel), mean_residual(wrong, seen, channel), 1e-9);
    CHECK(std::abs(mean_residual(model, sound, channel) - mean_residual(model, seen, channel)) > 1e-5);
  }
}

TEST(Balances, a_thermistor_that_lags_is_right_in_the_world_that_says_so) {
  constexpr double kLag = 30.0, kPeriod = 120.0, kPi = 3.14159265358979323846;
  const World model = leaf();
  Recording log = log_of(model, 0.0);
  const VectorXd waves = 25.0 + 3.0 * (2.0 * kPi / kPeriod * log.time_s.array()).sin();
  log.signals["temperature_1"] = waves;
  const Comparison sound = comparison_of(model, log, {});
  log.signals["temperature_1"] = lagged(log.time_s, waves, kLag);
  const Comparison seen = comparison_of(model, log, {});
  World wrong = model;
  wrong.thermistor_delay_s = kLag;
  // Between the ends, where a lag that is gone is settled and the average of the readings is whole.
  const auto apart = [&](const World& world) {
    const VectorXd a = predict(model, sound).channels[0] - sound.channels[0].measured,
                   b = predict(world, seen).channels[0] - seen.channels[0].measured;
    return (a - b).segment(kRest + 900, 800).cwiseAbs().maxCoeff();
  };
  CHECK(apart(wrong) < 0.3 * apart(model));
}

TEST(Balances, a_surface_that_the_model_knows_to_lag_is_the_same_cell_within) {
  constexpr double kLag = 40.0;
  const World model = leaf();
  Recording log = log_of(model, 0.0, 120.0);
  log.signals["temperature_1"] = VectorXd::Constant(kRows, model.car.battery.initial_temperature_c);
  const VectorXd within = predict(model, comparison_of(model, log, {})).battery.temperature_c;
  log.signals["temperature_1"] = within;
  const Comparison sound = comparison_of(model, log, {});
  log.signals["temperature_1"] = lagged(log.time_s, within, kLag);
  World knows = model;
  knows.car.cell.surface_lag_s = kLag;
  const Comparison seen = comparison_of(knows, log, {});
  CHECK(seen.facts.above_surface_k.maxCoeff() > 0.3);
  DOUBLES_EQUAL(0.0, mean_residual(knows, seen, "temperature"), 0.01);
  CHECK(std::abs(mean_residual(model, comparison_of(model, log, {}), "temperature")) > 0.05);
  // Between the ends of the load the tables are read at what is within.
  const auto apart = [&](const World& world, const Comparison& c) {
    return (predict(model, sound).channels[0] - predict(world, c).channels[0])
        .segment(kRest + 300, 1200)
        .cwiseAbs()
        .maxCoeff();
  };
  CHECK(apart(knows, seen) < 0.2 * apart(model, comparison_of(model, log, {})));
}

TEST(Balances, a_cause_of_the_heat_leaves_the_voltage_beside_measured_surfaces_alone) {
  World model = leaf();
  model.car.cell.surface_lag_s = 40.0;
  Recording log = log_of(model, 0.0, 120.0);
  log.signals["temperature_1"] = VectorXd::LinSpaced(kRows, 22.0, 26.0);
  const Comparison seen = comparison_of(model, log, {});
  World hotter = model;
  hotter.car.cell.heat_capacity_j_per_kg_k *= 0.5;
  const auto voltage = [&](const World& world) {
    for (std::size_t k = 0; k < seen.channels.size(); ++k) {
      if (seen.channels[k].name == "voltage") return predict(world, seen).channels[k];
    }
    return VectorXd();
  };
  CHECK(voltage(model).size() > 0);
  DOUBLES_EQUAL(0.0, (voltage(model) - voltage(hotter)).cwiseAbs().maxCoeff(), 0.0);
}

TEST(Balances, a_late_pack_voltage_is_late_by_what_the_model_says_between_the_readings_of_cells_in_turn) {
  constexpr double kStep_s = 0.01, kDelay_s = 0.01;
  constexpr Index kAt = 1505, kTurn = 3;  // the load comes between two readings of the cells
  World model = leaf();
  model.car.battery.cells_in_series = 2;
  Recording log;
  log.time_s = VectorXd::LinSpaced(kRows, 0.0, kStep_s * (kRows - 1));
  VectorXd& current = log.signals["current"];
  current = VectorXd::Zero(kRows);
  current.tail(kRows - kAt).setConstant(kLoad);
  log.signals["pack_voltage"] = VectorXd::Constant(kRows, 7.8);
  for (const char* cell : {"cell_voltage_1", "cell_voltage_2"}) {
    VectorXd& volts = log.signals[cell];
    volts = VectorXd::Constant(kRows, 3.9);
    for (Index row = kAt - kAt % kTurn + kTurn; row < kRows; ++row) volts(row) = 3.85;
  }
  const Comparison c = comparison_of(model, log, {});
  const Prediction sound = predict(model, c);
  model.voltage.delay_s = kDelay_s;
  const Prediction late = predict(model, c);
  for (std::size_t k = 0; k < c.channels.size(); ++k) {
    if (c.channels[k].name != "pack_voltage") continue;
    const VectorXd added = late.channels[k] - sound.channels[k];
    const double sag = 2.0 * (sound.battery.voltage_v(kAt - 1) - sound.battery.voltage_v(kAt));
    CHECK(sag > 0.01);
    DOUBLES_EQUAL(sag, added(kAt), 0.02 * sag);  // of the first row of the load the late sensor knows nothing
    for (const Index row : {kAt - 2, kAt + 1, kAt + 2, kAt + 4}) CHECK(std::abs(added(row)) < 0.05 * sag);
  }
}

TEST(Balances, corners_of_the_table_of_the_open_circuit_voltage_are_no_steps_of_its_slope) {
  const World model = load_model(DataFolder(VOLTLAP_DATA_FOLDER), "molicel_p45b", {}).world;
  Recording log;
  constexpr Index kSteps = 8000;  // of a full discharge at 1C; its table has a value every 5 to 10 % of SOC
  log.time_s = VectorXd::LinSpaced(kSteps, 0.0, 3600.0);
  log.signals["current"] = VectorXd::Constant(kSteps, model.car.cell.capacity_ah);
  log.signals["voltage"] = VectorXd::Constant(kSteps, 3.7);
  Comparison on = comparison_of(model, log, {});
  on.facts.starts_at_rest = false;
  on.facts.initial_soc = 1.0;
  const VectorXd slope = predict(model, on).battery.ocv_slope_v;
  const VectorXd steps = (slope.tail(kSteps - 1) - slope.head(kSteps - 1)).cwiseAbs();
  const double range = slope.maxCoeff() - slope.minCoeff();
  CHECK(range > 0.2);
  CHECK_TEXT(steps.maxCoeff() < 0.02 * range, std::to_string(steps.maxCoeff() / range).c_str());
}
