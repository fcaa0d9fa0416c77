// SPDX-License-Identifier: Apache-2.0
#include "bms/faults.hpp"

#include "base/require.hpp"
#include "bms/plausibility.hpp"

namespace voltlap::bms {
namespace {

using can::BmsFault;

struct Finding {
  Seen condition = Seen::kUnknown;
  bool dated = false;  ///< `since` is known from the sample itself, not from when it was first noticed
  Instant since{};
};

Finding active_if(bool active) { return Finding{active ? Seen::kActive : Seen::kClear, false, {}}; }
constexpr Finding kHeld{Seen::kHold, {}, {}};
/// What is seen to be wrong is wrong, whatever else is missing.
Finding unknown_unless(bool known, Finding finding) {
  return known || finding.condition == Seen::kActive ? finding : Finding{};
}

constexpr PackVoltage kTouchable = PackVoltage::from_raw(600'000);  // 60 V, EV.5.4.5 and EV.7.2.2

Finding cell_voltage_low(const Config& c, const State& s, Instant) {
  const bool any = s.pack.weakest_cell != kNoCell;
  return unknown_unless(s.pack.cells_good, active_if(any && s.pack.cell_min < c.cell_voltage_trip_low));
}
Finding cell_voltage_high(const Config& c, const State& s, Instant) {
  const bool any = s.pack.weakest_cell != kNoCell;
  return unknown_unless(s.pack.cells_good, active_if(any && s.pack.cell_max > c.cell_voltage_trip_high));
}
Finding temperature_high(const Config& c, const State& s, Instant) {
  const bool any = s.pack.hottest_sensor != kNoCell;
  return unknown_unless(s.pack.temperatures_good, active_if(any && s.pack.temperature_max >= c.temperature_trip));
}

Finding lost_since(bool good, Instant since) {
  return Finding{good ? Seen::kClear : Seen::kActive, true, since};
}
/// Once everything has been good a time of zero is that of the clock.
template <class T>
Finding lost(const State& s, const Sample<T>& sample) {
  return lost_since(sample.good(), s.pack.complete_once ? sample.time : waiting_since(sample, s.start));
}
Finding cell_measurement_lost(const Config&, const State& s, Instant) {
  return lost_since(s.pack.cells_good, s.pack.oldest_cell);
}
Finding temperature_measurement_lost(const Config&, const State& s, Instant) {
  return lost_since(s.pack.temperatures_good, s.pack.oldest_temperature);
}
Finding current_measurement_lost(const Config&, const State& s, Instant) {
  return lost(s, s.measured.current);
}

/// Without it no cell can be held against the pack. When the whole frame is lost, that of the current is told.
Finding pack_voltage_lost(const Config&, const State& s, Instant) {
  if (!s.measured.current.good()) return Finding{};
  return lost(s, s.measured.pack_voltage);
}

Finding discharge_current_high(const Config& c, const State& s, Instant) {
  const Sample<Current>& current = s.measured.current;
  return current.good() ? active_if(current.value > c.discharge_current_trip) : Finding{};
}
Finding charge_current_high(const Config& c, const State& s, Instant) {
  const Sample<Current>& current = s.measured.current;
  return current.good() ? active_if(-current.value > c.charge_current_trip) : Finding{};
}

Finding precharge_timeout(const Config&, const State& s, Instant) { return active_if(s.contactors.precharge_failed); }

/// An auxiliary contact that says closed without command.
Finding contactor_welded(const Config&, const State& s, Instant) {
  if (!s.measured.io.good()) return Finding{};
  const VehicleIo& io = s.measured.io.value;
  const ContactorCommand& command = s.contactors.command;
  return active_if((io.air_plus_aux && !command.air_plus) || (io.air_minus_aux && !command.air_minus) ||
                   (io.precharge_aux && !command.precharge));
}
/// An auxiliary contact that says open in spite of the command.
Finding contactor_stuck_open(const Config&, const State& s, Instant) {
  if (!s.measured.io.good()) return Finding{};
  const VehicleIo& io = s.measured.io.value;
  const ContactorCommand& command = s.contactors.command;
  return active_if((!io.air_plus_aux && command.air_plus) || (!io.air_minus_aux && command.air_minus) ||
                   (!io.precharge_aux && command.precharge));
}
/// A main contactor that falls open while it carries the tractive system. It must not close again on its own: what the
/// inverter has drawn meanwhile from the DC link would come back through no precharge resistor.
Finding contactor_dropped(const Config&, const State& s, Instant) {
  if (!s.measured.io.good()) return Finding{};
  const bool active = s.contactors.state == can::BmsState::kTsActive || s.contactors.state == can::BmsState::kCharging;
  return active_if(active && !(s.measured.io.value.air_plus_aux && s.measured.io.value.air_minus_aux));
}
/// The DC link still stands at the pack's voltage, or above 60 V, when it should long be discharged, or came up in no
/// time.
Finding dc_link_connected(const Config& c, const State& s, Instant now) {
  if (s.contactors.precharge_too_fast) return active_if(true);
  if (!s.measured.dc_link_voltage.good() || !s.measured.pack_voltage.good()) return Finding{};
  const bool long_open = !commanded(s.contactors.command) && now - s.contactors.opened_at >= c.discharge_time;
  const std::int64_t share = std::int64_t{s.measured.pack_voltage.value.raw()} * c.dc_link_welded.raw();
  const PackVoltage link = s.measured.dc_link_voltage.value;
  return active_if(long_open && (link > kTouchable || std::int64_t{link.raw()} * 1'000'000 > share));
}

/// The monitor tests itself at power-on and says so by the same line: with open contactors that only keeps them open.
/// It opens the shutdown circuit as well, so that what was closed when it began is often open before the time is up.
Finding isolation_fault(const Config& c, const State& s, Instant now) {
  if (!s.measured.io.good()) return Finding{};
  const Contactors& contactors = s.contactors;
  const Duration lately = Duration::from_ms(2 * c.isolation_time.ms());
  const bool closed = commanded(contactors.command) ||
                      (contactors.closed_once && now - contactors.opened_at <= lately) ||
                      is_set(s.faults, BmsFault::kIsolationFault);
  return active_if(closed && s.measured.io.value.isolation_fault);
}

Finding vehicle_io_lost(const Config&, const State& s, Instant) { return active_if(!s.measured.io.good()); }
Finding inverter_lost(const Config&, const State& s, Instant) { return active_if(!s.measured.dc_link_voltage.good()); }
Finding master_lost(const Config&, const State& s, Instant) { return active_if(!s.measured.master.good()); }

Finding voltage_implausible(const Config& c, const State& s, Instant) {
  const bool known = s.pack.cells_good && s.measured.pack_voltage.good();
  return known ? active_if(s.voltage_check.lasting && voltages_disagree(c, s.pack)) : Finding{};
}
/// At a current that changes the cells and the pack were not measured at the same current.
Finding cell_missing(const Config&, const State& s, Instant) {
  if (!s.voltage_check.steady) return kHeld;
  return active_if(s.voltage_check.cell_missing);
}
Finding pack_voltage_frozen(const Config&, const State& s, Instant) { return active_if(s.voltage_check.frozen); }
Finding cell_count_wrong(const Config&, const State& s, Instant) { return active_if(s.voltage_check.count_wrong); }
Finding cell_frozen(const Config&, const State& s, Instant) { return active_if(s.cell_check.frozen != kNoCell); }
Finding cell_off_level(const Config&, const State& s, Instant) {
  return active_if(s.cell_check.off_level != kNoCell);
}
Finding temperature_too_fast(const Config&, const State& s, Instant) {
  return active_if(s.temperature_check.too_fast != kNoCell);
}
Finding temperature_apart(const Config&, const State& s, Instant) {
  return active_if(s.temperature_check.apart != kNoCell);
}
Finding current_against_sag(const Config&, const State& s, Instant) {
  return active_if(s.current_check.reversed || s.current_check.frozen);
}
Finding current_against_power(const Config&, const State& s, Instant) {
  if (!s.current_check.power_judged) return kHeld;
  return active_if(s.current_check.power_wrong);
}
Finding current_offset(const Config&, const State& s, Instant) { return active_if(s.current_check.offset_too_large); }

Finding foreign_frames(const Config&, const State& s, Instant) { return active_if(s.rx.contested()); }
Finding config_invalid(const Config&, const State& s, Instant) { return active_if(!s.config_ok); }

enum class Effect : std::uint8_t {
  kReport,   ///< told on the bus
  kOpen,     ///< opens the contactors as long as it lasts
  kTrip,     ///< opens the contactors, after the torque, and stays latched
  kTripNow,  ///< the same at once: waiting would close or weld something
};

struct FaultRow {
  BmsFault fault;
  Finding (*find)(const Config&, const State&, Instant);
  Duration Config::*time;  ///< nullptr: at once
  Effect effect;
};

// One row a fault, with its requirement; two rows may set one bit.
constexpr FaultRow kTable[] = {
    {BmsFault::kCellVoltageLow, cell_voltage_low, &Config::voltage_trip_time, Effect::kTrip},  // BMS-010
    {BmsFault::kCellVoltageHigh, cell_voltage_high, &Config::voltage_trip_time, Effect::kTrip},  // BMS-011
    {BmsFault::kTemperatureHigh, temperature_high, &Config::temperature_trip_time, Effect::kTrip},  // BMS-012
    {BmsFault::kCellMeasurementLost, cell_measurement_lost, &Config::measurement_lost_time, Effect::kTrip},  // BMS-013
    {BmsFault::kTemperatureMeasurementLost, temperature_measurement_lost, &Config::measurement_lost_time,
     Effect::kTrip},  // BMS-014
    {BmsFault::kCurrentMeasurementLost, current_measurement_lost, &Config::measurement_lost_time,
     Effect::kTrip},  // BMS-015
    {BmsFault::kDischargeCurrentHigh, discharge_current_high, &Config::current_trip_time, Effect::kTrip},  // BMS-016
    {BmsFault::kChargeCurrentHigh, charge_current_high, &Config::current_trip_time, Effect::kTrip},  // BMS-016
    {BmsFault::kPrechargeTimeout, precharge_timeout, nullptr, Effect::kTripNow},  // BMS-017
    {BmsFault::kContactorWelded, contactor_welded, &Config::contactor_time, Effect::kTripNow},  // BMS-018
    {BmsFault::kContactorWelded, dc_link_connected, nullptr, Effect::kTripNow},  // BMS-018
    {BmsFault::kContactorStuckOpen, contactor_stuck_open, &Config::contactor_time, Effect::kTripNow},  // BMS-019
    {BmsFault::kContactorStuckOpen, contactor_dropped, &Config::contactor_drop_time, Effect::kTripNow},  // BMS-019
    {BmsFault::kIsolationFault, isolation_fault, &Config::isolation_time, Effect::kTrip},  // BMS-036
    {BmsFault::kVehicleIoLost, vehicle_io_lost, nullptr, Effect::kOpen},  // BMS-020
    {BmsFault::kInverterLost, inverter_lost, nullptr, Effect::kReport},
    {BmsFault::kMasterLost, master_lost, nullptr, Effect::kOpen},  // BMS-021
    {BmsFault::kVoltageImplausible, voltage_implausible, &Config::mismatch_time, Effect::kTrip},  // BMS-022
    {BmsFault::kVoltageImplausible, pack_voltage_lost, &Config::measurement_lost_time, Effect::kTrip},  // BMS-026
    {BmsFault::kConfigInvalid, config_invalid, nullptr, Effect::kTripNow},  // BMS-002
    {BmsFault::kCellImplausible, cell_frozen, &Config::implausible_time, Effect::kTrip},  // BMS-060
    {BmsFault::kCellImplausible, cell_off_level, &Config::implausible_time, Effect::kTrip},  // BMS-061
    {BmsFault::kVoltageImplausible, cell_missing, &Config::mismatch_time, Effect::kTrip},  // BMS-062
    {BmsFault::kVoltageImplausible, cell_count_wrong, &Config::implausible_time, Effect::kTrip},  // BMS-063
    {BmsFault::kVoltageImplausible, pack_voltage_frozen, &Config::implausible_time, Effect::kTrip},  // BMS-069
    {BmsFault::kTemperatureImplausible, temperature_too_fast, &Config::implausible_time, Effect::kTrip},  // BMS-064
    {BmsFault::kTemperatureImplausible, temperature_apart, &Config::implausible_time, Effect::kTrip},  // BMS-064
    {BmsFault::kCurrentImplausible, current_against_sag, &Config::implausible_time, Effect::kTrip},  // BMS-066
    {BmsFault::kCurrentImplausible, current_against_power, &Config::implausible_time, Effect::kTrip},  // BMS-067
    {BmsFault::kCurrentImplausible, current_offset, &Config::implausible_time, Effect::kTrip},  // BMS-068
    {BmsFault::kForeignFrames, foreign_frames, nullptr, Effect::kReport},  // BMS-004; what it makes lost acts above
};
constexpr std::size_t kRows = sizeof(kTable) / sizeof(kTable[0]);
static_assert(kRows == kFaultRows, "State keeps one timer a row");

constexpr bool latches(Effect effect) { return effect == Effect::kTrip || effect == Effect::kTripNow; }

// BMS-024
/// Since a good sample, or, when gaps come again and again, for twice the time in all.
void time_dated(const Finding& finding, Duration elapsed, Duration time, Instant now, FaultTimer& timer) {
  const bool lost = finding.condition == Seen::kActive;
  count(finding.condition, elapsed, Duration::from_ms(2 * time.ms()), timer);
  timer.set = timer.set || (lost && now - finding.since >= time);
}

void time_row(const FaultRow& row, const Config& config, const Finding& finding, Instant now, State& state,
              FaultTimer& timer) {
  const Duration time = row.time == nullptr ? Duration{} : config.*row.time;
  const Duration elapsed = max(now - state.last, Duration{});
  if (finding.dated) {
    time_dated(finding, elapsed, time, now, timer);
  } else {
    count(finding.condition, elapsed, time, timer);
  }
}

// BMS-023, EV.7.2.3: a new request of the master, with the tractive system off.
bool reset_requested(State& state) {
  const Sample<MasterRequest>& master = state.measured.master;
  const bool requested = master.good() && master.value.reset;
  const bool rising = requested && state.faults.reset_released;
  state.faults.reset_released = master.good() && !master.value.reset;
  const bool off = !commanded(state.contactors.command) && !master.value.tractive_system;
  return rising && off;
}

}  // namespace

void judge_faults(const Config& config, Instant now, State& state) {
  // Before the first complete set of measurements nothing can be closed and nothing is latched.
  const bool latching = state.contactors.state != can::BmsState::kInvalid;
  bool healthy = true;
  std::uint32_t bits = 0;
  std::uint32_t latched = state.faults.latched;
  for (std::size_t i = 0; i < kRows; ++i) {
    const FaultRow& row = kTable[i];
    const Finding finding = row.find(config, state, now);
    FaultTimer& timer = state.faults.timer[i];
    if (finding.condition == Seen::kClear && idle(timer)) continue;  // as nearly always
    // Nothing is counted before there was anything to lose.
    if (!latching && finding.condition == Seen::kClear) timer = FaultTimer{};
    time_row(row, config, finding, now, state, timer);
    if (timer.set) bits |= bit_of(row.fault);
    if (!latches(row.effect)) continue;
    healthy = healthy && (finding.condition == Seen::kClear || finding.condition == Seen::kHold);
    if (timer.set && latching) latched |= bit_of(row.fault);
  }
  if (latching && reset_requested(state) && healthy) {
    latched = 0;
    bits = 0;
    for (FaultTimer& timer : state.faults.timer) timer = FaultTimer{};
  }
  state.faults.latched = latched;
  state.faults.bits = bits | latched;
  state.faults.open = latched != 0;
  state.faults.open_now = false;
  for (const FaultRow& row : kTable) {
    if (row.effect == Effect::kReport || !is_set(state.faults, row.fault)) continue;
    state.faults.open = true;
    if (row.effect == Effect::kTripNow || row.fault == BmsFault::kVehicleIoLost) state.faults.open_now = true;
  }
  VOLTLAP_REQUIRE(state.faults.latched == 0 || state.faults.open);
}

}  // namespace voltlap::bms
