// SPDX-License-Identifier: Apache-2.0
#include "bms/waits_for.hpp"

#include "bms/charge/on_charger.hpp"

namespace voltlap::bms {
namespace {

using can::BmsState;
using can::SuspectWhy;
using can::WaitsFor;

WaitsFor missing(const Config& config, const State& s) {
  if (!s.pack.cells_good) return WaitsFor::kCells;
  if (!s.pack.temperatures_good) return WaitsFor::kTemperatures;
  if (!s.measured.current.good()) return WaitsFor::kCurrent;
  if (!s.measured.pack_voltage.good()) return WaitsFor::kPackVoltage;
  if (!s.measured.io.good()) return WaitsFor::kVehicleIo;
  if (s.contactors.state == BmsState::kInvalid && !s.current_check.offset_known) return WaitsFor::kCurrentOffset;
  if (!soc_ready(config, s.soc)) return WaitsFor::kSoc;
  return s.measured.master.good() ? WaitsFor::kNone : WaitsFor::kMaster;
}

bool aux_closed(const State& s) {
  const VehicleIo& io = s.measured.io.value;
  return io.air_plus_aux || io.air_minus_aux || io.precharge_aux;
}

bool dc_link_charged(const Config& config, const State& s) {
  const Measured& m = s.measured;
  return !s.contactors.closed_once && std::int64_t{m.dc_link_voltage.value.raw()} * 1'000'000 >=
                                          std::int64_t{m.pack_voltage.value.raw()} * config.dc_link_welded.raw();
}

}  // namespace

// BMS-035
WaitsFor waits_for(const Config& config, const State& s) {
  const Contactors& c = s.contactors;
  if (c.state == BmsState::kPrecharge || c.state == BmsState::kTsActive || charges(s)) return WaitsFor::kNone;
  if (c.state != BmsState::kInvalid && s.faults.open) return WaitsFor::kFaultGone;
  const WaitsFor first = missing(config, s);
  if (first != WaitsFor::kNone) return first;
  const bool charger_waits = s.charge.phase == can::ChargePhase::kWaiting;  // ChargeStatus says for what
  if (on_charger(s.measured) && !charger_waits) return WaitsFor::kChargeSwitchOff;
  if (c.state == BmsState::kInvalid || c.state == BmsState::kOpen) {
    if (s.measured.master.value.tractive_system) return WaitsFor::kRequestReleased;
    return aux_closed(s) ? WaitsFor::kContactorsOpen : WaitsFor::kNone;
  }
  if (s.measured.io.value.interlock_open) return WaitsFor::kInterlock;
  if (s.measured.io.value.isolation_fault) return WaitsFor::kIsolation;
  if (!s.measured.io.value.shutdown_closed) return WaitsFor::kShutdownCircuit;
  if (!s.measured.dc_link_voltage.good()) return WaitsFor::kDcLinkVoltage;
  if (dc_link_charged(config, s)) return WaitsFor::kDcLinkDischarged;
  return c.precharges >= config.precharge_attempts ? WaitsFor::kPrechargeCooled : WaitsFor::kNone;
}

Suspect find_suspect(const State& s) {
  if (s.cell_check.frozen != kNoCell) return {s.cell_check.frozen, SuspectWhy::kNoResponse};
  if (s.cell_check.off_level != kNoCell) return {s.cell_check.off_level, SuspectWhy::kLevel};
  if (s.temperature_check.too_fast != kNoCell) return {s.temperature_check.too_fast, SuspectWhy::kRate};
  if (s.temperature_check.apart != kNoCell) return {s.temperature_check.apart, SuspectWhy::kSpread};
  if (s.current_check.reversed) return {kNoCell, SuspectWhy::kReversed};
  if (s.current_check.frozen) return {kNoCell, SuspectWhy::kCurrentFrozen};
  if (s.current_check.power_judged && s.current_check.power_wrong) return {kNoCell, SuspectWhy::kPower};
  if (s.current_check.offset_too_large) return {kNoCell, SuspectWhy::kOffset};
  const bool uneven = s.charge.phase == can::ChargePhase::kStopped && s.charge.reason == s.charge.last;
  return uneven ? Suspect{s.charge.off_cell, SuspectWhy::kUneven} : Suspect{};
}

}  // namespace voltlap::bms
