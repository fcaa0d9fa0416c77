// SPDX-License-Identifier: Apache-2.0
#include "learn/bench/plan_rows.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

using Plan = BenchPlan;

template <auto Section, auto Field>
constexpr PlanAccess at() {
  return +[](Plan & plan) -> auto& {
    return (plan.*Section).*Field;
  };
}

template <auto Field>
constexpr PlanAccess sensor() {
  return +[](Plan & plan) -> auto& {
    return plan.instruments.sensors.*Field;
  };
}

constexpr std::string_view kAll = "pulse random hppc", kResistors = "pulse random", kRandom = "random",
                           kHppc = "hppc";

using Test = TestSection;
using Load = LoadSection;
using Schedule = ScheduleSection;
using Rest = RestSection;
using Cells = BenchCellsSection;
using Box = BoxSection;
using Meter = InstrumentSection;

constexpr PlanRow kRows[] = {
    {"description", "", 0, 0, kAll, false, +[](Plan& p) -> std::string& { return p.description; },
     "what it is for"},

    {"test.temperature_c", "degC", -40, 80, kAll, true, at<&Plan::test, &Test::temperature_c>(), "temperatures"},
    {"test.current_a", "A", 0.001, 5000, "pulse hppc", true, at<&Plan::test, &Test::current_a>(),
     "nominal currents; every one at every temperature is a test"},
    {"test.capacity_at_a", "A", 0.001, 5000, "pulse hppc", false, at<&Plan::test, &Test::capacity_at_a>(),
     "currents that the values of test.capacity_ah belong to"},
    {"test.capacity_ah", "Ah", 0.001, 1000, "pulse hppc", true, at<&Plan::test, &Test::capacity_ah>(),
     "capacity that pulse times are reckoned with"},
    {"test.initial_rest_s", "s", 0, 86400, kAll, true, at<&Plan::test, &Test::initial_rest_s>(),
     "rest before the first pulse"},
    {"test.pause_h", "h", 0, 1000, kAll, true, at<&Plan::test, &Test::pause_h>(),
     "charge and rest before the next test"},

    {"load.kind", "resistor|cycler", 0, 0, kAll, true, at<&Plan::load, &Load::kind>(), "what draws the current"},
    {"load.low_bank_ohm", "ohm", 1e-4, 1e4, kResistors, false, at<&Plan::load, &Load::low_bank_ohm>(),
     "low bank as measured"},
    {"load.high_bank_ohm", "ohm", 1e-4, 1e4, kResistors, false, at<&Plan::load, &Load::high_bank_ohm>(),
     "one resistor of the high bank"},
    {"load.high_bank_count", "1", 0, 100, kResistors, false, at<&Plan::load, &Load::high_bank_count>(),
     "resistors of the high bank, connected in parallel"},
    {"load.nominal_cell_v", "V", 0.5, 5, kResistors, false, at<&Plan::load, &Load::nominal_cell_v>(),
     "cell voltage that turns a nominal current into resistors"},
    {"load.resistors", "1", 1, 100, kRandom, false, at<&Plan::load, &Load::resistors>(),
     "how many of the high bank, pulse by pulse; without it they are drawn"},
    {"load.resistor_seed", "1", 0, 2e9, kRandom, false, at<&Plan::load, &Load::resistor_seed>(),
     "seed of that draw"},
    {"load.resistors_max", "1", 2, 100, kRandom, true, at<&Plan::load, &Load::resistors_max>(),
     "most resistors of a pulse"},
    {"load.difference_max", "1", 1, 100, kRandom, true, at<&Plan::load, &Load::difference_max>(),
     "most resistors changed between two pulses"},

    {"schedule.soc", "1", 0, 1, "pulse hppc", true, at<&Plan::schedule, &Schedule::soc>(),
     "SOC from high to low, with"},
    {"schedule.step", "1", 0.001, 1, "pulse hppc", true, at<&Plan::schedule, &Schedule::step>(),
     "SOC of a pulse in between"},
    {"schedule.fine_below", "1", 0, 1, "pulse hppc", false, at<&Plan::schedule, &Schedule::fine_below>(),
     "SOC below which fine_step holds"},
    {"schedule.fine_step", "1", 0, 1, "pulse hppc", false, at<&Plan::schedule, &Schedule::fine_step>(),
     "SOC of a pulse there; 0: none"},
    {"schedule.pulse_s", "s", 0.1, 86400, "random hppc", true, at<&Plan::schedule, &Schedule::pulse_s>(),
     "length of a pulse"},
    {"schedule.pulse_rest_s", "s", 0, 86400, kHppc, true, at<&Plan::schedule, &Schedule::pulse_rest_s>(),
     "rest between discharge and charge pulse"},
    {"schedule.charge_ratio", "1", 0, 2, kHppc, true, at<&Plan::schedule, &Schedule::charge_ratio>(),
     "charge pulse over discharge pulse; 0: none"},
    {"schedule.set_current_a", "A", 0.001, 5000, kHppc, true, at<&Plan::schedule, &Schedule::set_current_a>(),
     "current from one SOC to the next"},

    {"rest.rule", "relaxed|fixed", 0, 0, kAll, true, at<&Plan::rest, &Rest::rule>(), "when a rest ends"},
    {"rest.seconds", "s", 0, 86400, kAll, false, at<&Plan::rest, &Rest::seconds>(), "length of a fixed rest"},
    {"rest.rise_v_per_min", "V/min", 1e-6, 0.1, kAll, true, at<&Plan::rest, &Rest::rise_v_per_min>(),
     "relaxed: no cell rises faster"},
    {"rest.window_s", "s", 2, 3600, kAll, true, at<&Plan::rest, &Rest::window_s>(),
     "readings that the rise is judged from"},
    {"rest.max_s", "s", 1, 1e6, kAll, true, at<&Plan::rest, &Rest::max_s>(), "a rest ends then at the latest"},

    {"stop.cell_voltage_min_v", "V", 0.1, 5, kAll, true, at<&Plan::stop, &StopSection::cell_voltage_min_v>(),
     "reading of any cell under load that ends the test"},
    {"stop.cell_voltage_max_v", "V", 0.1, 5.5, kHppc, true, at<&Plan::stop, &StopSection::cell_voltage_max_v>(),
     "reading of any cell that ends a charge pulse"},
    {"stop.cell_temperature_max_c", "degC", -20, 120, kAll, true,
     at<&Plan::stop, &StopSection::cell_temperature_max_c>(), "reading of any thermistor that ends the test"},

    {"cells.count", "1", 1, 144, kAll, true, at<&Plan::cells, &Cells::count>(), "cells in series"},
    {"cells.initial_soc", "1", 0, 1, kAll, true, at<&Plan::cells, &Cells::initial_soc>(), "SOC at the start"},
    {"cells.capacity_spread", "1", 0, 0.3, kAll, false, at<&Plan::cells, &Cells::capacity_spread>(),
     "standard deviation between cells, relative"},
    {"cells.resistance_spread", "1", 0, 0.3, kAll, false, at<&Plan::cells, &Cells::resistance_spread>(),
     "standard deviation between cells, relative"},
    {"cells.soc_spread", "1", 0, 0.2, kAll, false, at<&Plan::cells, &Cells::soc_spread>(),
     "standard deviation of the initial SOC, new in every test"},
    {"cells.capacity_scale", "1", 0.1, 2, kAll, false, at<&Plan::cells, &Cells::capacity_scale>(),
     "given, one a cell"},
    {"cells.resistance_scale", "1", 0.1, 10, kAll, false, at<&Plan::cells, &Cells::resistance_scale>(),
     "given, one a cell"},
    {"cells.soc_offset", "1", -1, 1, kAll, false, at<&Plan::cells, &Cells::soc_offset>(), "given, one a cell"},

    {"box.mode", "bath|controlled|free", 0, 0, kAll, true, at<&Plan::box, &Box::mode>(),
     "cells held exactly, air by heater and fan, or an insulated box"},
    {"box.band_k", "K", 0.1, 50, kAll, true, at<&Plan::box, &Box::band_k>(),
     "controlled: a pulse waits until all cells are in it"},
    {"box.fan_convection_w_per_m2_k", "W/m2/K", 0.1, 1000, kAll, true,
     at<&Plan::box, &Box::fan_convection_w_per_m2_k>(), "controlled: of the cells' surface"},
    {"box.gain", "1", 0, 100, kAll, true, at<&Plan::box, &Box::gain>(),
     "controlled: K of air for each K of the cells"},
    {"box.air_min_c", "degC", -60, 80, kAll, true, at<&Plan::box, &Box::air_min_c>(), "controlled: coldest air"},
    {"box.air_max_c", "degC", -60, 120, kAll, true, at<&Plan::box, &Box::air_max_c>(), "controlled: hottest air"},
    {"box.room_c", "degC", -40, 60, kAll, true, at<&Plan::box, &Box::room_c>(), "free: outside the box"},
    {"box.loss_w_per_k", "W/K", 0.001, 1000, kAll, true, at<&Plan::box, &Box::loss_w_per_k>(),
     "free: through the box's walls"},

    {"sampling.rate_hz", "Hz", 0.1, 1000, kAll, true, at<&Plan::sampling, &SamplingSection::rate_hz>(), "readings"},
    {"sampling.log_hz", "Hz", 0.01, 1000, kAll, true, at<&Plan::sampling, &SamplingSection::log_hz>(),
     "rows of the table"},
    {"sampling.resample", "mean|first", 0, 0, kAll, true, at<&Plan::sampling, &SamplingSection::resample>(),
     "which readings make a row"},

    {"instruments.noise", "-", 0, 1, kAll, true, sensor<&SensorSection::noise>(), "noise of the readings"},
    {"instruments.quantisation", "-", 0, 1, kAll, true, sensor<&SensorSection::quantisation>(),
     "steps of the readings"},
    {"instruments.systematic", "-", 0, 1, kAll, true, at<&Plan::instruments, &Meter::systematic>(),
     "offsets and gains, drawn by the seed within the bounds below"},
    {"instruments.cell_step_v", "V", 0, 0.1, kAll, true, sensor<&SensorSection::cell_step_v>(),
     "step of a cell voltage"},
    {"instruments.cell_noise_v", "V", 0, 0.1, kAll, true, sensor<&SensorSection::cell_noise_v>(),
     "standard deviation"},
    {"instruments.cell_error_v", "V", 0, 0.5, kAll, true, at<&Plan::instruments, &Meter::cell_error_v>(),
     "bound of the systematic error at 5 V, half offset, half gain"},
    {"instruments.current_low_range_a", "A", 0, 1e4, kAll, true, sensor<&SensorSection::current_low_range_a>(),
     "where the fine channel ends"},
    {"instruments.current_low_step_a", "A", 0, 10, kAll, true, sensor<&SensorSection::current_low_step_a>(),
     "step, fine channel"},
    {"instruments.current_low_noise_a", "A", 0, 100, kAll, true, sensor<&SensorSection::current_low_noise_a>(),
     "standard deviation, fine channel"},
    {"instruments.current_low_offset_a", "A", 0, 100, kAll, true,
     at<&Plan::instruments, &Meter::current_low_offset_a>(), "bound of the systematic offset, fine channel"},
    {"instruments.current_low_gain", "1", 0, 0.2, kAll, true, at<&Plan::instruments, &Meter::current_low_gain>(),
     "bound of the systematic gain, fine channel"},
    {"instruments.current_high_step_a", "A", 0, 10, kAll, true, sensor<&SensorSection::current_high_step_a>(),
     "step, coarse channel"},
    {"instruments.current_high_noise_a", "A", 0, 100, kAll, true, sensor<&SensorSection::current_high_noise_a>(),
     "standard deviation, coarse channel"},
    {"instruments.current_high_offset_a", "A", 0, 100, kAll, true,
     at<&Plan::instruments, &Meter::current_high_offset_a>(), "bound of the systematic offset, coarse channel"},
    {"instruments.current_high_gain", "1", 0, 0.2, kAll, true, at<&Plan::instruments, &Meter::current_high_gain>(),
     "bound of the systematic gain, coarse channel"},
    {"instruments.temperature_step_k", "K", 0, 5, kAll, true, sensor<&SensorSection::temperature_step_k>(),
     "step of a thermistor"},
    {"instruments.temperature_noise_k", "K", 0, 10, kAll, true, sensor<&SensorSection::temperature_noise_k>(),
     "standard deviation"},
    {"instruments.temperature_error_k", "K", 0, 10, kAll, true,
     at<&Plan::instruments, &Meter::temperature_error_k>(), "a thermistor reads 0 to this too much"},
};

}  // namespace

std::span<const PlanRow> plan_rows() {
  return kRows;
}

const PlanRow* find_plan_row(std::string_view key) {
  const auto* found =
      std::find_if(std::begin(kRows), std::end(kRows), [&](const PlanRow& row) { return row.key == key; });
  return found == std::end(kRows) ? nullptr : found;
}

std::string plan_expectation(const PlanRow& row) {
  const std::string range =
      fmt::format("{} from {} to {}", row.unit == "1" ? "" : fmt::format(" in {}", row.unit), row.low, row.high);
  switch (row.access.index()) {
    case 0:
      return "a number" + range;
    case 1:
      return "a whole number" + range;
    case 2:
      return "true or false";
    case 3:
      return row.unit.empty() ? "a text in quotes" : fmt::format("one of {}", row.unit);
    default:
      return "a number or a list of numbers" + range;
  }
}

double schedule_capacity_ah(const TestSection& test, double current_a) {
  VOLTLAP_DEMAND(!test.capacity_ah.empty());
  const auto& at = test.capacity_at_a;
  const auto& capacity = test.capacity_ah;
  if (capacity.size() == 1 || current_a <= at.front()) return capacity.front();
  if (current_a >= at.back()) return capacity.back();
  VOLTLAP_DEMAND(increasing(at) && capacity.size() == at.size());
  const auto above = static_cast<std::size_t>(std::upper_bound(at.begin(), at.end(), current_a) - at.begin());
  const double fraction = (current_a - at[above - 1]) / (at[above] - at[above - 1]);
  return capacity[above - 1] + fraction * (capacity[above] - capacity[above - 1]);
}

}  // namespace voltlap::plant
