// SPDX-License-Identifier: Apache-2.0
// The plant's cell through the recorded current: voltage, SOC, what the resistances take, heat and temperature of
// the cell that stands for all. Circuit and heat as in car/battery/pack.hpp and car/battery/cell_effects.hpp.
#pragma once
#include <Eigen/Dense>

#include "explain/balances/recording.hpp"
#include "explain/balances/counted_charge.hpp"
#include "explain/balances/world.hpp"
#include "io/logs/cell_log.hpp"

namespace voltlap::plant {

/// What is known of a log before it is simulated.
struct LogFacts {
  CurrentHold hold = CurrentHold::kLinear;  ///< of the current between rows
  double initial_soc = 1.0;                 ///< where no rest tells it
  bool starts_at_rest = false;              ///< then the three below say how full the cell is
  double first_rest_s = 0.0;                ///< how long that rest is
  double charged_before_a = 0.0;            ///< mean current of a cell before the log, which left branches charged
  double rest_voltage_v = 0.0;              ///< of one cell, as read
  double rest_current_a = 0.0;              ///< of the pack, as read
  double rest_ohm = 0.0;                    ///< of one cell: what that current takes from the voltage
  double initial_temperature_c = 25.0;
  bool temperature_known = true;  ///< by thermistors, or stated
  Eigen::VectorXd temperature_c;  ///< measured mean, last value held; empty: not measured
  Eigen::VectorXd thermistor_c;   ///< what thermistors read, where temperature_c is what the cell is believed to be
  Eigen::VectorXd
      above_surface_k;  ///< the cell above its measured surface, by the model as it was given; empty: nothing
  Eigen::VectorXd ambient_above_model_k;  ///< measured, last value held; empty: the model's holds
  double air_step_k = 0.0;                ///< of who asks, its last digit: then it does; 0: nobody says it
  std::vector<bool> stopped;              ///< the car stands, or draws nothing for 3 s
  Eigen::VectorXd current_a;              ///< as logged, its noise averaged while nothing is drawn
  CurrentRange usual;                  ///< of the pack's
  Eigen::VectorXd beyond_straight_a2;  ///< mean square of the pack's on the way to a row; empty: as rows tell it
  Eigen::VectorXd counted_a;  ///< mean from the row before, of the pack, as its counter says; empty: there is none
  std::vector<bool> at_rest;              ///< where it is averaged
  double rest_noise_a = 0.0;  ///< of the pack: what its sensor reads of nothing, and no cell is asked at such a current
  std::vector<bool> at_limit;             ///< where it reads the limit of its sensor; empty: nowhere
  Eigen::VectorXd voltage_v;              ///< of one cell as logged, last value held; empty: not measured
  std::vector<Eigen::Index> gaps;  ///< rows before which nothing was recorded for long: a rest, as far as is known
  std::vector<double> soc_after_gap;  ///< its change in each, as far as the voltage tells it; empty: none
  double sensor_cells = 0.0;       ///< cells that one sensor of that voltage spans; 0: many sensors, none counts
};

struct BatteryResponse {
  Eigen::VectorXd current_a;  ///< of one cell, without the sensor's error; at its limit what the voltage asks for
  Eigen::VectorXd voltage_v;  ///< of one cell
  Eigen::VectorXd soc, ocv_slope_v;
  Eigen::VectorXd drop_v;         ///< OCV minus voltage
  Eigen::VectorXd r0_ohm;         ///< what a step of the current meets at once
  Eigen::VectorXd temperature_c;  ///< from its own heat
  Eigen::VectorXd surface_c;      ///< where a thermistor sits, behind it by `cell.surface_lag_s`
};

[[nodiscard]] BatteryResponse battery_response(const World& world, const Recording& log, const LogFacts& facts);

/// SOC by which a first rest is off that reads the open-circuit voltage off by 1 mV.
[[nodiscard]] double soc_per_millivolt(const BatteryResponse& battery);

/// values(t + shift_s), straight between rows; the ends hold.
[[nodiscard]] Eigen::VectorXd shifted(const Eigen::VectorXd& time_s, const Eigen::VectorXd& values, double shift_s);

/// What a sensor with this error reads where `values` is true.
[[nodiscard]] Eigen::VectorXd reading(const SensorError& error, const Eigen::VectorXd& time_s,
                                      const Eigen::VectorXd& values);

/// Mean over the rows within `window_s` on each side.
[[nodiscard]] Eigen::VectorXd smoothed(const Eigen::VectorXd& time_s, const Eigen::VectorXd& values,
                                       double window_s);

/// By the rows on both sides.
[[nodiscard]] Eigen::VectorXd rate_of_change(const Eigen::VectorXd& time_s, const Eigen::VectorXd& values);
/// How fast the thermistors' readings rise, for what is late behind its cell.
[[nodiscard]] Eigen::VectorXd thermistor_rate(const Eigen::VectorXd& time_s, const LogFacts& facts);

/// First-order lag behind `values`, beginning without one.
[[nodiscard]] Eigen::VectorXd lagged(const Eigen::VectorXd& time_s, const Eigen::VectorXd& values, double tau_s);

/// By how much cells are warmer than their surface, by the heat of a model; nothing where the surface follows at once.
void settle_above_surface(const World& model, const Recording& log, LogFacts& facts);

}  // namespace voltlap::plant
