// SPDX-License-Identifier: Apache-2.0
// A plan of the virtual test bench, as plain data in SI units (files: plant_sim/data/bench/*.toml; reference study,
// 2016, chapter 5). Keys, units and ranges: learn/bench/plan_rows.cpp.
#pragma once
#include <string>
#include <vector>

#include "core/parameters.hpp"

namespace voltlap::plant {

/// Every temperature with every current is one test.
struct TestSection {
  std::vector<double> temperature_c;
  std::vector<double> current_a;  ///< nominal; a random test draws its own
  std::vector<double>
      capacity_at_a;  ///< with capacity_ah: capacity of Eq. 5.1 over the current, straight in between
  std::vector<double> capacity_ah;
  double initial_rest_s = 0.0;
  double pause_h = 0.0;  ///< charging and resting before the next test
};

struct LoadSection {
  std::string kind;  ///< resistor | cycler
  double low_bank_ohm = 0.0;
  double high_bank_ohm = 0.0;  ///< one resistor of the high bank
  int high_bank_count = 0;
  double nominal_cell_v = 0.0;    ///< turns a nominal current into resistors, Eq. 5.2 and 5.3
  std::vector<double> resistors;  ///< of a random test: how many of the high bank, pulse by pulse; empty: drawn
  int resistor_seed = 0;          ///< of that draw, so that several plans can share one order
  int resistors_max = 0;
  int difference_max = 0;  ///< between neighbouring pulses
};

struct ScheduleSection {
  std::vector<double> soc, step;             ///< from soc[i] down to soc[i + 1] in pulses of step[i]
  double fine_below = 0.0, fine_step = 0.0;  ///< finer pulses at the low end; fine_step 0: none
  double pulse_s = 0.0;                      ///< random: each pulse; hppc: the short pulse
  double pulse_rest_s = 0.0;                 ///< hppc: between the discharge and the charge pulse
  double charge_ratio = 0.0;                 ///< hppc: charge pulse over discharge pulse
  double set_current_a = 0.0;                ///< hppc: from one SOC to the next
};

struct RestSection {
  std::string rule;  ///< relaxed | fixed
  double seconds = 0.0;
  double rise_v_per_min = 0.0;
  double window_s = 0.0;  ///< readings the rise is judged from
  double max_s = 0.0;
};

struct StopSection {
  double cell_voltage_min_v = 0.0;      ///< ends the test
  double cell_voltage_max_v = 0.0;      ///< ends a charge pulse
  double cell_temperature_max_c = 0.0;  ///< ends the test
};

struct BenchCellsSection {
  int count = 0;
  double initial_soc = 1.0;
  double capacity_spread = 0.0, resistance_spread = 0.0,
         soc_spread = 0.0;                                           ///< standard deviations, drawn by the seed
  std::vector<double> capacity_scale, resistance_scale, soc_offset;  ///< given instead of drawn
};

struct BoxSection {
  std::string mode;  ///< bath | controlled | free
  double band_k = 0.0;
  double fan_convection_w_per_m2_k = 0.0;
  double gain = 0.0;
  double air_min_c = 0.0, air_max_c = 0.0;
  double room_c = 0.0;
  double loss_w_per_k = 0.0;
};

struct SamplingSection {
  double rate_hz = 0.0, log_hz = 0.0;
  std::string resample;  ///< mean | first
};

struct InstrumentSection {
  SensorSection sensors;  ///< noise and steps
  bool systematic = false;
  double cell_error_v = 0.0;
  double current_low_offset_a = 0.0, current_high_offset_a = 0.0;
  double current_low_gain = 0.0, current_high_gain = 0.0;
  double temperature_error_k = 0.0;
};

struct BenchPlan {
  std::string name, kind, description;  ///< kind: pulse | random | hppc
  TestSection test;
  LoadSection load;
  ScheduleSection schedule;
  RestSection rest;
  StopSection stop;
  BenchCellsSection cells;
  BoxSection box;
  SamplingSection sampling;
  InstrumentSection instruments;
};

/// Capacity that Eq. 5.1 reckons with at a nominal current.
[[nodiscard]] double schedule_capacity_ah(const TestSection& test, double current_a);

}  // namespace voltlap::plant
