// SPDX-License-Identifier: Apache-2.0
// A charge: a car that stands on a charger, with the control units on its bus, from the switch to full and even cells.
//
// The control units step every 10 ms as on the road; cells, DC link and charger are integrated in longer steps, for
// what they do takes seconds. Contactors and shunts therefore follow a command up to one such step late.
#pragma once
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "can_dbc/car.hpp"
#include "car/car.hpp"
#include "core/parameters.hpp"
#include "io/bus/frame_sink.hpp"
#include "io/bus/plant_bus.hpp"
#include "race/sensors/pedal_sensors.hpp"
#include "race/sensors/sensor_faults.hpp"

namespace voltlap::plant {

/// What a test does to the car in a tick.
struct ChargeHand {
  double time_s;
  Car& car;
  SensorFaults& faults;
  bool& shutdown_closed;
  bool& charge_switch;
};

struct ChargeOptions {
  VehicleParameters vehicle;          ///< battery.initial_soc is where it begins
  double to_soc = 1.0;                ///< below 1 the switch is turned off when the mean of the cells is there
  std::uint64_t seed = 1;
  PedalSensors pedal_sensors{};
  int ticks_per_step = 10;            ///< of 10 ms: the plant's integration step
  double duration_max_s = 7.0 * 86'400.0;
  std::function<void(const ChargeHand&)> hand{};
};

/// A moment of the charge, every 10 s.
struct ChargeSample {
  double time_s, soc, soc_min, soc_max;
  double cell_min_v, cell_max_v;    ///< true, under what flows
  double open_spread_v;             ///< true open-circuit voltages, highest less lowest
  double current_a, asked_a;        ///< into the pack, and of the charger
  double pack_v, temperature_c;
  std::size_t cells_bled;
  can::ChargePhase phase;
  can::ChargeReason reason;
};

struct ChargeResult {
  bool full = false, stopped = false;  ///< stopped: interrupted from outside
  bool reached = false;                ///< `to_soc`, below 1
  bool idle = false;                   ///< given up: nothing flows, and what it waits for does not come by itself
  can::ChargePhase phase = can::ChargePhase::kNone;
  can::ChargeReason reason = can::ChargeReason::kNone;
  std::uint32_t faults = 0;            ///< of the BMS, at the end
  int off_cell = -1;                   ///< that the BMS could not balance, from 0; -1: none
  bool bms_counts = false;             ///< it has a state of charge
  double time_s = 0.0;                 ///< from power-on to the end
  double charging_s = 0.0, resting_s = 0.0, bleeding_s = 0.0, waiting_s = 0.0;
  double first_held_s = std::numeric_limits<double>::quiet_NaN();  ///< the highest cell was full for the first time
  double highest_cell_v = 0.0;         ///< true, at any time
  std::size_t highest_cell = 0;
  double lowest_open_v = 0.0, highest_open_v = 0.0;  ///< true open-circuit voltages at the end
  double begin_soc = 0.0, end_soc = 0.0, end_soc_min = 0.0, bms_soc = 0.0;
  double begin_spread_v = 0.0;         ///< of the open-circuit voltages
  double temperature_max_c = 0.0;      ///< of any cell, at any time
  double end_temperature_min_c = 0.0, end_temperature_max_c = 0.0;
  bool too_cold = false;               ///< which end of the range is nearer at the end
  double charge_in_ah = 0.0, energy_in_wh = 0.0;   ///< at the pack's terminals
  double charger_wh = 0.0;
  double bled_ah = 0.0, bled_wh = 0.0;             ///< all cells together
  double bled_open_s = 0.0;            ///< longest that a shunt stayed on with the shutdown circuit open
  std::uint32_t ticks = 0;
  std::uint64_t frames = 0;
  [[nodiscard]] double end_spread_v() const { return highest_open_v - lowest_open_v; }
};

class ChargeObserver : public FrameSink {
 public:
  virtual void on_sample(const ChargeSample& sample) = 0;
  [[nodiscard]] virtual bool stop_requested() = 0;
};

/// Runs until the BMS has ended the charge and opened the contactors, the switch was turned off, it waits for what
/// does not come by itself, or the time is over.
[[nodiscard]] ChargeResult run_charge(const ChargeOptions& options, PlantBus& bus, ChargeObserver& observer);

}  // namespace voltlap::plant
