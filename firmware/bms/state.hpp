// SPDX-License-Identifier: Apache-2.0
// Input, State and Output of the BMS. Each group of State is written by the one stage that its comment names.
#pragma once
#include <cstddef>
#include <cstdint>

#include "base/can_frame.hpp"
#include "base/persistence.hpp"
#include "base/sample.hpp"
#include "base/units.hpp"
#include "bms/cell_check.hpp"
#include "bms/charge/charge_state.hpp"
#include "bms/config.hpp"
#include "bms/current_check.hpp"
#include "bms/fault_timer.hpp"
#include "bms/limits/limits_state.hpp"
#include "bms/temperature_check.hpp"
#include "bms/voltage_check.hpp"
#include "bms/estimate/soc_estimator.hpp"
#include "can_dbc/car.hpp"
#include "can_dbc/tables.hpp"
#include "codec/amk_motors.hpp"
#include "codec/rx_monitor.hpp"

namespace voltlap::bms {

struct Input {
  Instant now{};
  FrameView frames{};
};

/// Auxiliary contacts and the shutdown circuit as the car reports them.
struct VehicleIo {
  bool air_plus_aux = false;
  bool air_minus_aux = false;
  bool precharge_aux = false;
  bool shutdown_closed = false;  ///< and the interlock, which sits in it
  bool charge_switch = false;
  bool interlock_open = false;   ///< a plug or a cover of the tractive system is loose
  bool isolation_fault = false;  ///< the isolation monitor reports one, or tests itself
};

struct MasterRequest {
  bool tractive_system = false;
  bool reset = false;
};

/// Written by ingest. A sample keeps its last good value and the time of it; its quality tells what came since.
struct Measured {
  Sample<CellVoltage> cell[kMaxCells] = {};
  Current cell_current[kMaxCells] = {};      ///< pack current at the time of the cell's sample
  PackVoltage cell_pack[kMaxCells] = {};     ///< pack voltage then
  std::uint64_t arrived = 0;                 ///< groups of cells whose frames came in this step, one bit each
  bool temperatures_arrived = false;         ///< some did in this step
  Sample<Temperature> temperature[kMaxTemperatures] = {};
  Sample<Current> current{};
  Sample<PackVoltage> pack_voltage{};
  Sample<PackVoltage> dc_link_voltage{};
  Sample<Current> phase_current{};      ///< of the motor, driving positive
  Sample<MotorSpeed> motor_speed{};
  codec::AmkMotors motors{};  ///< of a car with one a wheel
  Sample<VehicleIo> io{};
  Sample<MasterRequest> master{};
  Sample<ChargerReport> charger{};
  bool bled[kMaxCells] = {};            ///< by cell_look: the cell is read under a bleed, and reads too low
  bool some_bled = false;
};

static_assert(can::CellVoltages::kGroups <= 64, "one bit each");
inline constexpr std::size_t kCellsPerWord = 24;  ///< of BalancingCommand
static_assert(can::BalancingCommand::kGroups * can::BalancingCommand::kPerFrame * kCellsPerWord >= kMaxCells);

inline constexpr std::size_t kBledWords = can::BalancingCommand::kGroups * can::BalancingCommand::kPerFrame;

/// Every cell of the groups that came in this step.
template <class Visit>
void for_each_arrived(const Config& config, const Measured& measured, const Visit& visit) {
  for (std::size_t group = 0; measured.arrived >> group != 0; ++group) {
    if ((measured.arrived >> group & 1U) == 0) continue;
    const std::size_t first = group * can::CellVoltages::kPerFrame;
    for (std::size_t i = first; i < first + can::CellVoltages::kPerFrame && i < config.cells_in_series; ++i) visit(i);
  }
}

/// Written by plausibility: what the single samples say together.
struct Pack {
  bool cells_good = false;         ///< every cell
  bool temperatures_good = false;  ///< every sensor
  bool complete_once = false;      ///< everything of them, current and pack voltage have been good in one step
  std::uint8_t weakest_cell = kNoCell;
  CellVoltage cell_min{};  ///< over the good cells; meaningless when weakest_cell is kNoCell
  CellVoltage cell_max{};
  PackVoltage cell_sum{};
  PackVoltage sum_by_pack{};  ///< the same by the pack's channel: mean of its readings in the steps of the cells
  std::uint8_t hottest_sensor = kNoCell;
  Temperature temperature_min{};  ///< over the good sensors; meaningless when hottest_sensor is kNoCell
  Temperature temperature_max{};
  Instant oldest_cell{};  ///< last good sample of the cell that has waited longest
  Instant oldest_temperature{};
};

/// Written by faults: one timer a row of its table.
inline constexpr std::size_t kFaultRows = 31;
struct Faults {
  FaultTimer timer[kFaultRows] = {};
  std::uint32_t latched = 0;
  std::uint32_t bits = 0;  ///< set now or latched, as on the bus
  bool open = false;       ///< some fault that is set asks for open contactors
  bool open_now = false;   ///< one of them without waiting for the torque
  bool reset_released = false;
};

struct ContactorCommand {
  bool air_plus = false;
  bool air_minus = false;
  bool precharge = false;
};

/// Some contactor is to be closed.
[[nodiscard]] constexpr bool commanded(const ContactorCommand& c) { return c.air_plus || c.air_minus || c.precharge; }

/// Written by contactors.
struct Contactors {
  can::BmsState state = can::BmsState::kInvalid;
  Instant entered{};    ///< the state; not that of an opening, which has its own
  Instant opened_at{};  ///< all contactors commanded open since
  ContactorCommand command{};
  Instant opening_since{};        ///< an opening that waits for the current to go
  Instant credit_at{};            ///< of the last precharge that has been given back
  std::uint8_t precharges = 0;    ///< that the resistor has not cooled from
  bool for_charge = false;        ///< what is closed, or about to, is closed for a charger
  Persistence plugged{};          ///< the charger's switch is on
  bool plugged_in = false;        ///< long enough to be no bounce
  bool opening = false;           ///< limits and torque are zero, the contactors follow
  bool closed_once = false;       ///< since power-on
  bool dc_link_was_low = false;   ///< at the begin of precharge
  bool path_closed = false;       ///< AIR- and the precharge relay were seen closed in this precharge ...
  Instant path_closed_at{};       ///< ... since then
  bool precharge_failed = false;  ///< for one step: too slow
  bool precharge_too_fast = false;
};

struct Limit {
  Current value{};
  can::LimitReason reason = can::LimitReason::kNone;
  std::uint8_t cell = kNoCell;  ///< that sets the limit, when the reason is a cell
};

/// Written by limits.
struct Limits {
  Limit discharge{};
  Limit charge{};
};

struct State {
  // bms_step
  bool started = false;
  bool config_ok = false;
  can::WaitsFor self_test = can::WaitsFor::kNone;  ///< what failed at power-on; written before the first step alone
  std::uint32_t steps = 0;
  Instant start{};
  Instant last{};

  codec::RxMonitor<can::kBmsRx> rx{};  // ingest
  Measured measured{};                 // ingest
  Pack pack{};                         // plausibility
  SocEstimate soc{};                   // estimate/soc_estimator
  Resistance cell_resistance{};        // estimate/resistance, 10 Hz
  CellCheck cell_check{};              // cell_check
  CurrentCheck current_check{};        // current_check
  TemperatureCheck temperature_check{};  // temperature_check
  VoltageCheck voltage_check{};        // voltage_check
  Faults faults{};                     // faults
  Contactors contactors{};             // contactors
  Limits limits{};                     // limits
  LimitCaps caps{};                    // limits/table
  Ahead ahead{};                       // limits/ahead
  EnergyToGo energy_to_go{};           // limits/energy_to_go
  Charge charge{};                     // charge
  CellLook look{};                     // cell_look
  bool balancing[kMaxCells] = {};      // balancing
  std::uint8_t cells_bled = 0;         // balancing: how many
};

/// One cell as the Orion broadcasts it.
struct CellReport {
  std::uint8_t cell = 0;
  bool good = false;
  CellVoltage voltage{};
  CellVoltage open_voltage{};
  Resistance resistance{};
  bool balancing = false;
};

/// What goes to a charger and to the shunts; sent while `on`, and at once when something has been stopped.
struct ChargeReport {
  bool on = false;
  bool at_once = false;
  can::ChargePhase phase = can::ChargePhase::kNone;
  can::ChargeReason reason = can::ChargeReason::kNone;
  Current asked{};          ///< of the charger; zero: off
  PackVoltage voltage_max{};
  CellVoltage spread{};
  bool spread_known = false;
  std::uint8_t cells_bled = 0;
  std::uint32_t bled[kBledWords] = {};  ///< a bit a cell, as BalancingCommand has them
};

struct Output {
  Instant now{};
  ContactorCommand contactors{};
  Limits limits{};
  can::BmsState state = can::BmsState::kInvalid;
  std::uint32_t faults = 0;
  std::uint8_t weakest_cell = kNoCell;
  Soc soc{};
  bool soc_valid = false;
  Current current{};
  PackVoltage pack_voltage{};
  Temperature temperature_min{};
  Temperature temperature_max{};
  CellReport cell{};
  can::WaitsFor waits_for = can::WaitsFor::kNone;
  std::uint8_t suspect = kNoCell;
  can::SuspectWhy suspect_why = can::SuspectWhy::kNone;
  Current current_offset{};
  bool current_offset_known = false;
  ChargeReport charge{};
};

}  // namespace voltlap::bms
