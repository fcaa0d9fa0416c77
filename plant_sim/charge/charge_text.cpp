// SPDX-License-Identifier: Apache-2.0
#include "charge/charge_text.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

constexpr double kTellsWaiting_s = 30.0;  // every charge waits for its precharge

const char* words_of(can::ChargeReason reason) {
  switch (reason) {
    case can::ChargeReason::kTemperature:  // with its degrees, below
    case can::ChargeReason::kNone: return "nothing is told";
    case can::ChargeReason::kNoChargerInPack: return "this pack has no charger (bms.charger_current_max_a is 0)";
    case can::ChargeReason::kChargerSilent: return "the charger is silent";
    case can::ChargeReason::kChargerFault: return "the charger reports a fault";
    case can::ChargeReason::kChargerNotConnected: return "the charger sees no battery, or hears no command";
    case can::ChargeReason::kShutdownCircuit: return "the shutdown circuit is open";
    case can::ChargeReason::kFault: return "the BMS has a fault";
    case can::ChargeReason::kMeasurementLost: return "a measurement is missing";
    case can::ChargeReason::kLimit: return "the cells' charge limit is zero";
    case can::ChargeReason::kCurrentNotAsked: return "a current flows that was not asked for";
    case can::ChargeReason::kNoCurrent:
      return "the charge no longer grows: the current that is asked for does not flow";
    case can::ChargeReason::kBalancingTime: return "balancing took longer than bms.balancing_time_max_s";
    case can::ChargeReason::kNotBalanced: return "no cell that is too high may be bled (bms.balancing_voltage_min_v)";
    case can::ChargeReason::kUneven: return "balancing does not bring the cells together";
    case can::ChargeReason::kRequestReleased: return "the tractive system is asked for";
    case can::ChargeReason::kContactorsOpened: return "the contactors opened";
  }
  return "";
}

/// What two decimals show as nothing has no sign.
double unsigned_zero(double value) { return std::abs(value) < 0.005 ? 0.0 : value; }

std::string fault_words(std::uint32_t faults) {
  std::string out;
  for (std::size_t bit = 0; bit < can::kBmsFaultCount; ++bit) {
    if ((faults >> bit & 1U) != 0) out += std::string(out.empty() ? ": " : ", ") + can::kBmsFaultNames[bit];
  }
  return out;
}

std::string temperature_words(const ChargeResult& r) {
  if (r.too_cold) return fmt::format("the cells are too cold (coldest {:.1f} degC)", r.end_temperature_min_c);
  return fmt::format("the cells are too hot (hottest {:.1f} degC)", r.end_temperature_max_c);
}

std::string why_words(const ChargeResult& r) {
  if (r.reason == can::ChargeReason::kTemperature) return temperature_words(r);
  return words_of(r.reason) + (r.reason == can::ChargeReason::kFault ? fault_words(r.faults) : "");
}

}  // namespace

const char* phase_name(can::ChargePhase phase) { return can::kChargePhaseNames[static_cast<std::size_t>(phase)]; }
const char* reason_name(can::ChargeReason reason) { return can::kChargeReasonNames[static_cast<std::size_t>(reason)]; }

std::string duration_words(double seconds) {
  VOLTLAP_DEMAND(std::isfinite(seconds));
  const auto whole = static_cast<long long>(std::llround(seconds));
  if (whole >= 3600) return fmt::format("{} h {:02} min", whole / 3600, whole % 3600 / 60);
  if (whole >= 60) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} s", whole);
}

std::string ending_words(const ChargeResult& r) {
  if (r.full) return "every cell is full, and all are even";
  if (r.reached) return "the charge that was asked for is reached";
  if (r.stopped) return "interrupted";
  std::string why = why_words(r);
  if (r.off_cell >= 0) why += fmt::format("; cell {} stands farthest off", r.off_cell + 1);
  if (r.phase == can::ChargePhase::kStopped) return "broken off: " + why;
  if (r.idle && r.phase == can::ChargePhase::kWaiting) return "not begun: " + why;
  return (r.idle ? "given up, for hours nothing has flowed: " : "the time is over; last: ") + why;
}

std::string charge_text(const ChargeResult& r, const std::string& what) {
  std::string out = fmt::format("{}: {}\n", what, ending_words(r));
  const auto line = [&](const char* name, const std::string& value) {
    out += fmt::format("  {:<26}{}\n", name, value);
  };
  line("time", duration_words(r.time_s));
  if (r.waiting_s >= kTellsWaiting_s) line("  waiting", duration_words(r.waiting_s));
  line("  charging", duration_words(r.charging_s));
  line("  bleeding", duration_words(r.bleeding_s));
  line("  resting and measuring", duration_words(r.resting_s));
  if (std::isfinite(r.first_held_s)) line("first cell full after", duration_words(r.first_held_s));
  line("state of charge", fmt::format("{:.1f} % to {:.1f} %, emptiest cell {:.1f} %, {}", 100.0 * r.begin_soc,
                                      100.0 * r.end_soc, 100.0 * r.end_soc_min,
                                      r.bms_counts ? fmt::format("BMS {:.1f} %", 100.0 * r.bms_soc)
                                                   : "the BMS keeps no count"));
  line("highest cell voltage", fmt::format("{:.4f} V at any time (cell {})", r.highest_cell_v, r.highest_cell + 1));
  line("spread of open voltages", fmt::format("{:.1f} mV at the begin, {:.1f} mV at the end", 1e3 * r.begin_spread_v,
                                              1e3 * r.end_spread_v()));
  line("into the pack", fmt::format("{:.2f} Ah, {:.2f} kWh", unsigned_zero(r.charge_in_ah),
                                    unsigned_zero(1e-3 * r.energy_in_wh)));
  line("bled", fmt::format("{:.2f} Ah, {:.1f} Wh in the shunts of all cells", r.bled_ah, r.bled_wh));
  line("hottest cell", fmt::format("{:.1f} degC", r.temperature_max_c));
  return out;
}

}  // namespace voltlap::plant
