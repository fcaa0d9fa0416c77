// SPDX-License-Identifier: Apache-2.0
#include "bms/transmit.hpp"

#include "base/require.hpp"
#include "can_dbc/car.hpp"
#include "can_dbc/charger.hpp"
#include "can_dbc/orion.hpp"
#include "codec/message_table.hpp"
#include "codec/send.hpp"

namespace voltlap::bms {
namespace {

// Codes of 0x6B0 RelayState, by bit (can_dbc/orion.dbc)
constexpr std::uint16_t kRelayDischarge = 1U << 0;
constexpr std::uint16_t kRelayCharge = 1U << 1;
constexpr std::uint16_t kRelayMalfunction = 1U << 3;
constexpr std::uint16_t kRelayAlwaysOn = 1U << 5;
constexpr std::uint16_t kRelayReady = 1U << 6;
constexpr std::uint16_t kRelayCharging = 1U << 7;

/// A limit is rounded down to what its code can say: never more than was allowed.
std::int32_t rounded_down(Current limit, std::int32_t step_ma) { return limit.raw() / step_ma * step_ma; }

can::ContactorCommand contactor_command(const Output& out) {
  can::ContactorCommand m;
  m.air_plus_close = out.contactors.air_plus;
  m.air_minus_close = out.contactors.air_minus;
  m.precharge_close = out.contactors.precharge;
  m.waits_for = out.waits_for;
  m.suspect = out.suspect;
  m.suspect_why = out.suspect_why;
  m.current_offset_ma = out.current_offset.raw();
  m.current_offset_ok = out.current_offset_known;
  return m;
}

can::BmsLimits bms_limits(const Output& out) {
  constexpr std::int32_t kStepMa = 100;
  can::BmsLimits m;
  m.discharge_limit_ma = rounded_down(out.limits.discharge.value, kStepMa);
  m.discharge_limit_ok = true;
  m.charge_limit_ma = rounded_down(out.limits.charge.value, kStepMa);
  m.charge_limit_ok = true;
  m.discharge_reason = out.limits.discharge.reason;
  m.charge_reason = out.limits.charge.reason;
  m.limiting_cell = out.limits.discharge.cell;
  return m;
}

can::BmsStatus bms_status(const Output& out) {
  can::BmsStatus m;
  m.soc_ppm = out.soc.raw();
  m.soc_ok = out.soc_valid;
  m.state = out.state;
  m.faults = out.faults;
  m.weakest_cell = out.weakest_cell;
  return m;
}

std::uint16_t relay_state(const Output& out) {
  unsigned bits = kRelayAlwaysOn;
  if (out.limits.discharge.value > Current{}) bits |= kRelayDischarge;
  if (out.limits.charge.value > Current{}) bits |= kRelayCharge;
  if (out.faults != 0) bits |= kRelayMalfunction;
  if (out.state == can::BmsState::kTsActive) bits |= kRelayReady;
  if (out.state == can::BmsState::kCharging) bits |= kRelayCharging;
  return static_cast<std::uint16_t>(bits);
}

can::PackBroadcast pack_broadcast(const Output& out) {
  can::PackBroadcast m;
  m.pack_current_ma = out.current.raw();
  m.pack_voltage_100uv = out.pack_voltage.raw();
  m.pack_soc_ppm = out.soc.raw();
  m.relay_state = relay_state(out);
  return m;
}

/// A cell without a good sample is sent as 0 V: the Orion has no code for "not measured".
can::CellBroadcast cell_broadcast(const Output& out) {
  can::CellBroadcast m;
  m.cell_id = out.cell.cell;
  m.cell_balancing = out.cell.balancing;
  m.cell_resistance_uohm = out.cell.resistance.raw();
  if (out.cell.good) {
    m.cell_voltage_100uv = out.cell.voltage.raw();
    m.cell_open_voltage_100uv = out.cell.open_voltage.raw();
  }
  return m;
}

can::LimitBroadcast limit_broadcast(const Output& out) {
  constexpr std::int32_t kStepMa = 1000;
  can::LimitBroadcast m;
  m.pack_dcl_ma = rounded_down(out.limits.discharge.value, kStepMa);
  m.pack_ccl_ma = rounded_down(out.limits.charge.value, kStepMa);
  m.high_temperature_dc = out.temperature_max.raw();
  m.low_temperature_dc = out.temperature_min.raw();
  return m;
}

template <std::uint32_t kId>
bool is_due(Instant now) {
  constexpr std::size_t kRow = codec::find_row(can::kBmsTx, codec::row_count(can::kBmsTx), kId);
  static_assert(kRow != codec::kNoRow);
  return can::due(now.ms(), can::kBmsTx[kRow].cycle_ms, can::kBmsTx[kRow].delay_ms);
}

can::ChargeStatus charge_status(const ChargeReport& charge) {
  can::ChargeStatus m;
  m.phase = charge.phase;
  m.reason = charge.reason;
  m.cells_bled = charge.cells_bled;
  m.spread_100uv = charge.spread.raw();
  m.spread_ok = charge.spread_known;
  m.current_asked_ma = charge.asked.raw();
  m.current_asked_ok = true;
  return m;
}

/// Off carries no current to be misread by.
can::ChargerCommand charger_command(const ChargeReport& charge) {
  can::ChargerCommand m;
  const bool charges = charge.asked > Current{};
  if (charges) m.voltage_max_100uv = charge.voltage_max.raw();
  m.voltage_max_ok = true;
  m.current_max_ma = charge.asked.raw();
  m.current_max_ok = true;
  m.control = charges ? can::ChargerControl::kCharge : can::ChargerControl::kOff;
  return m;
}

can::BalancingCommand balancing_command(const ChargeReport& charge, std::uint8_t group) {
  can::BalancingCommand m;
  m.group = group;
  const std::uint32_t* bled = charge.bled + group * can::BalancingCommand::kPerFrame;
  for (std::uint32_t& cells : m.cells) cells = *bled++;
  return m;
}

/// On a charger alone: the bus of a race stays as it is.
void transmit_charge(const Output& out, codec::Sealer& sealer, TxQueue& tx) {
  const ChargeReport& charge = out.charge;
  if (!charge.on) return;
  constexpr std::uint32_t kFirst = can::BalancingCommand::kBaseId;
  const bool due[] = {is_due<kFirst>(out.now), is_due<kFirst + 1>(out.now), is_due<kFirst + 2>(out.now)};
  static_assert(sizeof(due) == can::BalancingCommand::kGroups);
  for (std::uint8_t group = 0; group < can::BalancingCommand::kGroups; ++group) {
    if (due[group] || charge.at_once) codec::send(balancing_command(charge, group), sealer, tx);
  }
  if (is_due<can::ChargeStatus::kId>(out.now)) codec::send(charge_status(charge), sealer, tx);
  if (is_due<can::ChargerCommand::kId>(out.now) || charge.at_once) codec::send(charger_command(charge), sealer, tx);
}

}  // namespace

void transmit(const Output& output, codec::Sealer& sealer, TxQueue& tx) {
  VOLTLAP_REQUIRE(output.limits.discharge.value >= Current{} && output.limits.charge.value >= Current{});
  codec::send(contactor_command(output), sealer, tx);
  codec::send(bms_limits(output), sealer, tx);
  codec::send(bms_status(output), sealer, tx);
  codec::send(pack_broadcast(output), sealer, tx);
  codec::send(cell_broadcast(output), sealer, tx);
  if (is_due<can::LimitBroadcast::kId>(output.now)) codec::send(limit_broadcast(output), sealer, tx);
  transmit_charge(output, sealer, tx);
}

}  // namespace voltlap::bms
