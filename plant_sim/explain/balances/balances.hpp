// SPDX-License-Identifier: Apache-2.0
// Structured residuals: each measured channel against what the model makes of its measured neighbours, so that one
// cause hits few channels.
//
//   voltage        cell's (or mean cell's, or pack's) voltage given the current
//   pack_voltage   pack voltage given the sum of the cells (where cells are recorded)
//                  (of a table whose cells were read at other times than its current: the pack's voltage given the
//                  current, and the mean cell's given the pack's)
//   bus_voltage    bus voltage given the pack voltage
//   soc            SOC in the log given the current (only where sound logs tell how the log's SOC is made)
//   temperature    mean thermistor given current and voltage
//   power          V I given torque and speed of the motor
//   speed          speed gained in the last seconds given torque and brake
//   motor_speed    motor speed given ground speed
//   motor_torque torque with the accelerator released
// and two groups, each member minus the group's mean: cell_voltage_<n>, temperature_<n>.
#pragma once
#include <Eigen/Dense>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "explain/balances/battery_response.hpp"

namespace voltlap::plant {

enum class Balance { kCharge, kVoltage, kHeat, kForce, kPower };
[[nodiscard]] const char* name_of(Balance balance);

struct BalanceChannel {
  std::string name;  ///< as listed above
  Balance balance;
  std::string unit;
  Eigen::VectorXd measured;  ///< NaN where not recorded or masked
};

/// Members of a group, each minus the mean of all.
struct Group {
  std::string stem;  ///< cell_voltage_ or temperature_
  Balance balance = Balance::kVoltage;
  std::vector<std::string> members;  ///< role names
  std::vector<Eigen::VectorXd> deviation;
};

/// A log ready to be compared: what is measured, and what is known beside it.
struct Comparison {
  Recording log;
  LogFacts facts;
  std::vector<BalanceChannel> channels;
  std::vector<Group> groups;
  Eigen::VectorXd soc;            ///< that the model has, by row; empty: not reckoned yet
  [[nodiscard]] const BalanceChannel* find(const std::string& name) const;
};

/// What else is known when a log is compared.
struct ComparisonOptions {
  bool soc_stated = false;  ///< the model says with which SOC the log begins
  bool judge_soc = false;   ///< the log's SOC is a channel of its own
  std::optional<CurrentHold> hold =
      {};  ///< of the current, as its logger is known to have it; else found in the log
  bool temperature_stated = true;  ///< the model says how warm the battery begins
  double air_step_k = 0.0;         ///< last digit with which the model says how warm the air of this log was; 0: not
};

/// Picks channels and facts (start SOC from the first rest, hold of the current) for this model. The battery of the
/// model is brought to the log's number of cells by the caller.
[[nodiscard]] Comparison comparison_of(const World& model, Recording log, const ComparisonOptions& options);

struct Prediction {
  std::vector<Eigen::VectorXd> channels;  ///< in the order of Comparison::channels
  BatteryResponse battery;
};
[[nodiscard]] Prediction predict(const World& world, const Comparison& comparison);
/// What a changed world can change: everything, the battery alone, or the car alone; the rest is as `before`.
enum class Acts { kOnAll, kOnBattery, kOnCar };
[[nodiscard]] Prediction predict(const World& world, const Comparison& comparison, const Prediction& before,
                                 Acts acts);
/// With other facts than the comparison has.
[[nodiscard]] Prediction predict(const World& world, const Comparison& comparison, const LogFacts& facts);
[[nodiscard]] Prediction predict(const World& world, const Comparison& comparison, const LogFacts& facts,
                                 const Prediction& before, Acts acts);

}  // namespace voltlap::plant
