// SPDX-License-Identifier: Apache-2.0
#include "bms/bms_step.hpp"

#include "base/interpolate.hpp"
#include "bms/charge/balancing.hpp"
#include "bms/charge/cell_look.hpp"
#include "bms/charge/charge.hpp"
#include "bms/charge/charge_config.hpp"
#include "bms/contactors.hpp"
#include "bms/estimate/resistance.hpp"
#include "bms/estimate/soc_coulomb.hpp"
#include "bms/estimate/soc_ekf.hpp"
#include "bms/faults.hpp"
#include "bms/ingest.hpp"
#include "bms/limits/limits.hpp"
#include "bms/plausibility.hpp"
#include "bms/waits_for.hpp"

namespace voltlap::bms {
namespace {

void start(const Config& config, Instant now, State& state) {
  state.started = true;
  state.config_ok = config_check(config) == ConfigError::kNone;
  state.start = now;
  state.last = now;
  state.contactors.entered = now;
  state.contactors.opened_at = now;
}

/// Nothing closed, nothing allowed, and why.
Output refuse(Instant now, can::WaitsFor why) {
  Output out;
  out.now = now;
  out.state = can::BmsState::kFault;
  out.faults = bit_of(can::BmsFault::kConfigInvalid);
  out.limits.discharge.reason = can::LimitReason::kFault;
  out.limits.charge.reason = can::LimitReason::kFault;
  out.waits_for = why;
  return out;
}

/// Between the coldest and the hottest sensor.
Temperature temperature_between(const Pack& pack) {
  return Temperature::from_raw((pack.temperature_min.raw() + pack.temperature_max.raw()) / 2);
}

void estimate(const Config& config, Instant now, bool slow, State& state) {
  const Measured& m = state.measured;
  const bool temperature_known = state.pack.hottest_sensor != kNoCell;
  estimate_soc(config,
               SocInput{m.cell, state.pack.cells_good, m.current, m.cell_current, now, temperature_between(state.pack),
                        temperature_known, m.some_bled ? m.bled : nullptr},
               state.soc);
  if (state.look.rested) recount_at_rest(config, state.look.cell, state.soc);
  const bool known = temperature_known && soc_ready(config, state.soc);
  if (slow && known) state.cell_resistance = cell_resistance(config.resistance, state.soc, state.pack.temperature_min);
}

void check_channels(const Config& config, Instant now, Duration elapsed, bool slow, State& state) {
  check_current(config, now, elapsed, state);
  check_cells(config, now, slow, state);
  check_temperatures(config, now, state);
  check_pack_voltage(config, now, elapsed, state);
}

// BMS-088
/// A cell with branches that are still charged stands elsewhere than V + I R says, as one that was just filled.
void report_by_filter(const Config& config, const State& state, std::size_t index, CellReport& report) {
  const CellFilter& filter = state.soc.filter.cell[index].filter;
  report.open_voltage =
      interpolate(config.ocv.soc, config.ocv.voltage, config.ocv.count, cell_soc(state.soc, index));
  report.resistance = Resistance::from_raw(product(state.cell_resistance.raw(), filter.rho, kUnitBits));
}

/// The next cell with every step, as the Orion broadcasts them.
CellReport report_cell(const Config& config, const State& state) {
  const std::size_t index = state.steps % config.cells_in_series;
  const Sample<CellVoltage>& sample = state.measured.cell[index];
  CellReport report;
  report.cell = static_cast<std::uint8_t>(index);
  report.good = sample.good();
  report.voltage = sample.value;
  report.balancing = state.balancing[index];
  if (config.soc_method == SocMethod::kEkf && state.soc.valid) {
    report_by_filter(config, state, index, report);
    return report;
  }
  // V + I R, with mA * uOhm = nV and 1e5 nV = 0.1 mV
  const std::int64_t drop_nv = std::int64_t{state.measured.cell_current[index].raw()} * state.cell_resistance.raw();
  report.open_voltage = CellVoltage::saturated(sample.value.raw() + drop_nv / 100'000);
  report.resistance = state.cell_resistance;
  return report;
}

ChargeReport report_charge(const Config& config, const State& s) {
  ChargeReport out;
  out.on = s.charge.phase != can::ChargePhase::kNone || s.charge.lingers;
  if (!out.on) return out;
  out.at_once = s.charge.at_once;
  out.phase = s.charge.phase;
  out.reason = s.charge.reason;
  out.asked = s.charge.asked;
  out.voltage_max = charger_voltage_max(config);
  out.spread = s.look.highest - s.look.lowest;
  out.spread_known = s.look.known;
  out.cells_bled = s.cells_bled;
  for (std::uint16_t i = 0; i < config.cells_in_series; ++i) {
    if (s.balancing[i]) out.bled[i / kCellsPerWord] |= std::uint32_t{1} << (i % kCellsPerWord);
  }
  return out;
}

Output report(const Config& config, Instant now, const State& state) {
  Output out;
  out.contactors = state.contactors.command;
  out.limits = state.limits;
  out.state = state.contactors.state;
  out.faults = state.faults.bits;
  out.weakest_cell = state.pack.weakest_cell;
  out.soc = state.soc.value;
  out.soc_valid = state.soc.valid;
  out.current = state.measured.current.value;
  out.pack_voltage = state.pack.cell_sum;
  out.temperature_min = state.pack.temperature_min;
  out.temperature_max = state.pack.temperature_max;
  out.cell = report_cell(config, state);
  out.waits_for = waits_for(config, state);
  const Suspect suspect = find_suspect(state);
  out.suspect = suspect.index;
  out.suspect_why = suspect.why;
  out.current_offset = state.current_check.offset;
  out.current_offset_known = state.current_check.offset_known;
  out.charge = report_charge(config, state);
  out.now = now;
  return out;
}

}  // namespace

Output step(const Config& config, const Input& input, State& state) {
  if (!state.started) start(config, input.now, state);
  if (!state.config_ok) return refuse(input.now, can::WaitsFor::kConfiguration);
  if (state.self_test != can::WaitsFor::kNone) return refuse(input.now, state.self_test);  // BMS-090
  const Duration elapsed = max(input.now - state.last, Duration{});
  const bool slow = state.steps % kSlowSteps == 0;

  ingest(config, input, state);
  mark_bled_cells(config, input.now, state);
  summarise(config, state.measured, state.start, state.pack);
  estimate(config, input.now, slow, state);
  check_channels(config, input.now, elapsed, slow, state);
  judge_faults(config, input.now, state);
  run_charge(config, input.now, elapsed, slow, state);
  sequence_contactors(config, input.now, state);
  update_limits(config, elapsed, state);
  request_balancing(config, state);

  const Output output = report(config, input.now, state);
  state.last = input.now;
  ++state.steps;
  return output;
}

}  // namespace voltlap::bms
